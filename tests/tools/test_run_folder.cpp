#include <sys/stat.h>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/error_code_of.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_record.h"
#include "tools/run/step_plots.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

int code_of_opening(const fs::path& path, ExistingFolder existing) {
  return error_code_of([&] { const RunFolder folder(path, existing); });
}

void fill_like_a_run(const fs::path& path) {
  const RunFolder folder(path, ExistingFolder::keep);
  make_file(folder.scene(), "x");
  make_file(folder.steps(), "x");
  make_file(folder.clip(), "x");
  for (const char* name : step_plot_names) make_file(folder.plots() / name, "x");
  write_run_record(folder.record(), {});
  for (int frame = 1; frame <= 3; ++frame) {
    make_file(folder.state(frame), "x");
    make_file(folder.picture(frame), "x");
    make_file(folder.picture(frame, ".exr"), "x");
  }
}

}  // namespace

TEST_CASE("a run makes its folder and the folders above it") {
  const TemporaryFolder temporary;
  const RunFolder folder(temporary / "a/b/run", ExistingFolder::refuse);
  CHECK(fs::is_directory(temporary / "a/b/run"));
  CHECK(folder.state(7) == temporary / "a/b/run/states/0007.state");
  CHECK(folder.picture(12345, ".exr") == temporary / "a/b/run/frames/12345.exr");
}

TEST_CASE("an existing folder is refused, even an empty one") {
  const TemporaryFolder temporary;
  CHECK(code_of_opening(temporary.path(), ExistingFolder::refuse) == 73);
  CHECK(error_code_of([&] { check_run_folder(temporary.path(), ExistingFolder::refuse); }) == 73);
  CHECK(code_of_opening(temporary.path(), ExistingFolder::keep) == 0);
}

TEST_CASE("a file in the way is refused") {
  const TemporaryFolder temporary;
  make_file(temporary / "run", "hello");
  for (const auto existing : {ExistingFolder::refuse, ExistingFolder::keep, ExistingFolder::overwrite})
    CHECK(code_of_opening(temporary / "run", existing) == 73);
  CHECK(file_text(temporary / "run") == "hello");
}

TEST_CASE("a folder that cannot be made is refused") {
  CHECK(code_of_opening("/dev/null/run", ExistingFolder::refuse) == 73);
}

TEST_CASE("a folder with other people's files is left alone") {
  const TemporaryFolder temporary;
  make_file(temporary / "run/thesis.txt", "x");
  CHECK(code_of_opening(temporary / "run", ExistingFolder::overwrite) == 73);
  CHECK(code_of_opening(temporary / "run", ExistingFolder::keep) == 73);
  CHECK(fs::exists(temporary / "run/thesis.txt"));
}

TEST_CASE("overwriting removes what a run made and nothing else") {
  const TemporaryFolder temporary;
  fill_like_a_run(temporary / "run");
  make_file(temporary / "run/notes.txt", "mine");
  make_file(temporary / "run/frames/best.png", "mine");
  make_file(temporary / "run/plots/mine.svg", "mine");
  const RunFolder folder(temporary / "run", ExistingFolder::overwrite);
  for (const fs::path& path : {folder.scene(), folder.steps(), folder.clip(), folder.record(), folder.state(1),
                               folder.picture(2), folder.picture(3, ".exr"), folder.plots() / step_plot_names[0]})
    CHECK(!fs::exists(path));
  CHECK(file_text(temporary / "run/notes.txt") == "mine");
  CHECK(file_text(temporary / "run/frames/best.png") == "mine");
  CHECK(file_text(temporary / "run/plots/mine.svg") == "mine");
}

TEST_CASE("a run that goes on keeps everything but what a killed run left half-written") {
  const TemporaryFolder temporary;
  fill_like_a_run(temporary / "run");
  make_file(temporary / "run/states/.0004.state.part-123", "half");
  make_file(temporary / "run/plots/.contacts.svg.part-123", "half");
  make_file(temporary / "run/.clip.mp4.part-123.mp4", "half");
  const RunFolder folder(temporary / "run", ExistingFolder::keep);
  CHECK(count_states(folder.path()) == 3);
  CHECK(fs::exists(folder.picture(3)));
  CHECK(!fs::exists(temporary / "run/states/.0004.state.part-123"));
  CHECK(!fs::exists(temporary / "run/plots/.contacts.svg.part-123"));
  CHECK(!fs::exists(temporary / "run/.clip.mp4.part-123.mp4"));
}

TEST_CASE("a folder in use by a living run is locked, whatever is asked") {
  const TemporaryFolder temporary;
  {
    const RunFolder living(temporary / "run", ExistingFolder::refuse);
    for (const auto existing : {ExistingFolder::refuse, ExistingFolder::keep, ExistingFolder::overwrite})
      CHECK(code_of_opening(temporary / "run", existing) == 75);
  }
  CHECK(code_of_opening(temporary / "run", ExistingFolder::keep) == 0);
}

TEST_CASE("a file that is not found since the run's folder has vanished is told as that") {
  const TemporaryFolder temporary;
  const RunFolder folder(temporary / "run", ExistingFolder::refuse);
  const auto told = [&] {
    try {
      read_file(folder.state(3));
    } catch (const Error& error) {
      return explained(folder, error);
    }
    return Error(Fault::internal, {"the state", "is there", "", ""});
  };
  CHECK(told().fault() == Fault::not_found);
  CHECK(told().text().where == folder.state(3));
  fs::rename(temporary / "run", temporary / "elsewhere");
  CHECK(told().fault() == Fault::io_error);
  CHECK(told().text().where == folder.path());
  CHECK(told().text().what == "has vanished");
  fs::rename(temporary / "elsewhere", temporary / "run");
}

TEST_CASE("states are counted up to the first gap") {
  const TemporaryFolder temporary;
  fill_like_a_run(temporary / "run");
  fs::remove(state_path(temporary / "run", 2));
  CHECK(count_states(temporary / "run") == 1);
}

TEST_CASE("a run's record comes back from run.json") {
  const TemporaryFolder temporary;
  RunRecord record;
  record.version = "1.2.3";
  record.scene = "figure \"x\"";
  record.steps = 1LL << 40;
  record.steps_not_converged = 3;
  record.simulate_seconds = 1.5;
  record.peak_memory = 123456789012;
  write_run_record(temporary / "run.json", record);
  const auto back = read_run_record(temporary / "run.json");
  REQUIRE(back);
  CHECK(back->version == "1.2.3");
  CHECK(back->scene == record.scene);
  CHECK(back->steps == record.steps);
  CHECK(back->steps_not_converged == 3);
  CHECK(back->seconds() == 1.5);
  CHECK(back->peak_memory == record.peak_memory);
  CHECK(!back->exit_status);
  CHECK(how_it_ended(*back, {}).starts_with("without a word"));

  record.caller = "process 7 on render07";
  record.instruction_set = "avx2 with OpenBLAS";
  record.calls_killed = 2;
  write_run_record(temporary / "run.json", record);
  const RunRecord again = read_run_record(temporary / "run.json").value();
  CHECK(again.instruction_set == record.instruction_set);
  CHECK(again.calls_killed == 2);
  Worker worker;
  worker.host = "render07", worker.process = 7;
  CHECK(how_it_ended(again, {worker}) == "not yet: process 7 on render07 is at work");
  record.exit_status = 139, record.ended = "crashed by SIGSEGV";
  write_run_record(temporary / "run.json", record);
  CHECK(how_it_ended(read_run_record(temporary / "run.json").value(), {worker}) == "crashed by SIGSEGV");

  make_file(temporary / "other.json", R"({"name": "package.json of somebody"})");
  CHECK(!read_run_record(temporary / "other.json"));
  make_file(temporary / "half.json", file_text(temporary / "run.json").substr(0, 40));
  CHECK(!read_run_record(temporary / "half.json"));
}
