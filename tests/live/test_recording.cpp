#include "tools/live/recording.h"

#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/run/run_folder.h"

using namespace umax;
using namespace umax::test;
namespace fs = std::filesystem;

namespace {

/// Runs a session with a change and a pull, as the loop does.
void run(Session& session, Recording& recording, int frames) {
  recording.keep(1, session.state, session.simulation.digest);
  for (int i = 0; i < frames * session.substeps(); ++i) {
    if (i == 5) set_key(session, 0, 0.06);
    if (i == 9) set_key(session, key_of(session, "body.block.material.density"), 700);
    if (i == 12) grab(session, {0, 3, {0.1, 0.8, 0}});
    if (i == 16) release(session);
    step(session);
    if (session.at_frame()) recording.keep(session.frame(), session.state, session.simulation.digest);
  }
}

}  // namespace

TEST_CASE("a session as a run's folder is what umax simulate makes of its scene, byte for byte") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  Recording recording(folder / "live", ExistingFolder::refuse, 100);
  run(session, recording, 12);
  const SessionRun saved = save_run(session, recording);
  CHECK(saved.frames == 13);
  REQUIRE(saved.run == folder / "live/session-01");
  CHECK(count_states(saved.run) == 13);

  const fs::path again = folder / "again";
  const ProcessResult result = umax_program({"simulate", saved.scene.string(), "-o", again.string()});
  INFO(result.messages);
  REQUIRE(result.exit_code == 0);
  CHECK(states_of(again) == states_of(saved.run));
  CHECK(steps_without_time(again) == steps_without_time(saved.run));
  // it goes on from there, and its states are its scene's
  const ProcessResult resumed =
      umax_program({"simulate", (saved.run / "scene.toml").string(), "-o", saved.run.string(), "--resume"});
  INFO(resumed.messages);
  CHECK(resumed.exit_code == 0);
  CHECK(states_of(again) == states_of(saved.run));
}

TEST_CASE("a session as a run's folder is rendered") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  Recording recording(folder / "live", ExistingFolder::refuse, 100);
  run(session, recording, 3);
  const SessionRun saved = save_run(session, recording);
  const ProcessResult result =
      umax_program({"render", saved.run.string(), "--size", "32x18", "--samples", "1", "--frames", "4"});
  INFO(result.messages);
  CHECK(result.exit_code == 0);
  CHECK(fs::exists(saved.run / "frames/0004.png"));
}

TEST_CASE("no more states are kept than asked for, and a session that has lost some is still saved as a scene") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  Recording recording(folder / "live", ExistingFolder::refuse, 4);
  run(session, recording, 12);
  CHECK(recording.first_frame() == 10);
  CHECK(recording.last_frame() == 13);
  CHECK(std::distance(fs::directory_iterator(folder / "live/states"), fs::directory_iterator()) == 4);
  CHECK_FALSE(recording.state(9));
  REQUIRE(recording.state(13));
  CHECK(bytes_of(*recording.state(13)) == bytes_of(session.state));
  const SessionRun saved = save_run(session, recording);
  CHECK(saved.run.empty());
  CHECK(fs::exists(saved.scene));
}

TEST_CASE("going back drops states, and a frame that comes again replaces what it was") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  Recording recording(folder / "live", ExistingFolder::refuse, 100);
  run(session, recording, 6);
  recording.cut(3);
  CHECK(recording.last_frame() == 3);
  CHECK_FALSE(fs::exists(folder / "live/states/0004.state"));
  recording.keep(2, session.state, session.simulation.digest);
  CHECK(recording.last_frame() == 2);
  recording.keep(1, session.state, session.simulation.digest);
  CHECK(recording.first_frame() == 1);
  CHECK(recording.last_frame() == 1);
}

TEST_CASE("a folder that is there is refused, and with --overwrite saved sessions stay") {
  const TemporaryFolder folder;
  {
    Session session(live_scene(folder));
    Recording recording(folder / "live", ExistingFolder::refuse, 100);
    run(session, recording, 2);
    save_session(session, recording);
    CHECK(recording.new_name() == "session-02");
  }
  CHECK(failure_of([&] { check_live_folder(folder / "live", ExistingFolder::refuse); }).code == 73);
  make_file(folder / "live/.session-02.toml.part-123", "half");  // as after a kill
  const Recording again(folder / "live", ExistingFolder::overwrite, 100);
  CHECK_FALSE(fs::exists(folder / "live/.session-02.toml.part-123"));
  CHECK(again.first_frame() == 0);
  CHECK(fs::is_empty(folder / "live/states"));
  CHECK(fs::exists(folder / "live/session-01.toml"));
  make_file(folder / "mine/notes.txt", "mine");
  CHECK(failure_of([&] { const Recording no(folder / "mine", ExistingFolder::overwrite, 9); }).code == 73);
}
