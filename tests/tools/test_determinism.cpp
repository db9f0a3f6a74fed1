// One scene, one result: the states' hashes for 1 and 2 threads, and for a run that was stopped and taken up again.
#include <memory>
#include <string>
#include <vector>

#include "core/files/sha256.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/hex_bar.h"
#include "tools/setup/simulation_setup.h"
#include "tools/system/threads.h"

using namespace umax;

namespace {

struct Run {
  std::vector<std::string> hashes;  // of the state after each step
  int limits = 0, contacts = 0;     // most active
};

// restart_every > 0: the state goes through its file's bytes and on into a new workspace after that many steps
Run run(const Simulation& simulation, int threads, int steps, int restart_every) {
  const ThreadLimit limit(threads);
  Run result;
  State state = rest_state(simulation.model);
  auto workspace = std::make_unique<Workspace>(simulation.model);
  for (int i = 1; i <= steps; ++i) {
    const StepReport report = step(simulation.model, simulation.options, *workspace, state);
    result.limits = std::max(result.limits, report.limits_active);
    result.contacts = std::max(result.contacts, report.contacts);
    const std::string bytes = encode_state(state, simulation.digest);
    result.hashes.push_back(sha256_hex(bytes));
    if (restart_every > 0 && i % restart_every == 0) {
      Digest made_with;
      state = decode_state(bytes, "a state", made_with);
      REQUIRE(made_with == simulation.digest);
      workspace = std::make_unique<Workspace>(simulation.model);
    }
  }
  return result;
}

// limits and contacts: how many must at least have acted, so that what could differ was at work
void check_one_result(const std::string& scene, const std::vector<std::string>& sets, int steps, int limits,
                      int contacts) {
  std::vector<Override> overrides;
  for (const std::string& text : sets) overrides.push_back(parse_override(text));
  const Simulation simulation = set_up(load_scene(scene, overrides));
  const Run whole = run(simulation, 1, steps, 0);
  CHECK(whole.limits >= limits);
  CHECK(whole.contacts >= contacts);
  CHECK(run(simulation, 2, steps, 0).hashes == whole.hashes);
  CHECK(run(simulation, 2, steps, 3).hashes == whole.hashes);
}

}  // namespace

TEST_CASE("the beam's states are the same bytes for any threads and restarts") {
  check_one_result("beam", {}, 40, 10, 0);
}

TEST_CASE("the sphere's states are the same bytes for any threads and restarts") {
  check_one_result("sphere", {"body.sphere.position=[0,1.05,0]", "body.sphere.velocity=[0.5,-4.4,0]"}, 40, 10, 2);
}

TEST_CASE("the states of a body of irregular hexes are the same bytes for any threads and restarts") {
  const TemporaryFolder folder;
  make_file(folder / "bar.msh", testing::gmsh_4(testing::document_of(testing::twisted_bar()), true));
  make_file(folder / "bar.toml", testing::bar_scene("bar.msh"));
  check_one_result((folder / "bar.toml").string(), {}, 30, 10, 4);
}

TEST_CASE("the pressed ball's states are the same bytes for any threads and restarts") {
  const std::vector<std::string> sets = {
      "obstacle.plate.position={ keys = [[0, [0, 1.101, 0]], [0.2, [0, 0.95, 0]]], interpolation = \"linear\" }",
      "body.ball.limit.stretch=\"20 %\""};
  check_one_result("press", sets, 12, 10, 6);
}

TEST_CASE("the tumbling figure's states are the same bytes for any threads and restarts") {
  check_one_result("tumble", {"body.figure.position=[-1.1,2.3,0]", "body.figure.velocity=[0,-4.5,0]"}, 8, 10, 10);
}
