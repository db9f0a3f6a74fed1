// Keys of density, friction, damping and gravity: a value that is held acts as if it had always been there.
#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"

using namespace umax;
using namespace umax::test;

namespace {

Points positions_after(const Scene& scene, int steps) {
  const Simulation simulation = set_up(scene);
  Stepping stepping = begin_stepping(simulation);
  State state = rest_state(simulation.model);
  for (int i = 0; i < steps; ++i) advance(stepping, {}, state);
  return state.positions;
}

double difference(const Points& a, const Points& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("a key that holds another value from before the first step on is that value") {
  const TemporaryFolder folder;
  struct Case {
    std::string before, keyed, after;
  };
  const std::string at = "] ], interpolation = \"hold\" }\n";
  const auto [before, keyed, after] = GENERATE_COPY(
      Case{"friction = 0\n", "friction = { keys = [ [0, 0], [0.001, 0.9" + at, "friction = 0.9\n"},
      Case{"material.density = 500\n", "material.density = { keys = [ [0, 500], [0.001, 2000" + at,
           "material.density = 2000\n"},
      Case{"material.damping_mass = 0\n", "material.damping_mass = { keys = [ [0, 0], [0.001, 6" + at,
           "material.damping_mass = 6\n"},
      Case{"material.damping_stiffness = 0\n", "material.damping_stiffness = { keys = [ [0, 0], [0.001, 0.02" + at,
           "material.damping_stiffness = 0.02\n"});
  CAPTURE(keyed);
  const std::string thrown = "velocity = [2, 0, 0]\n";
  const Points with_keys = positions_after(live_scene(folder, thrown + keyed), 40);
  CHECK(difference(with_keys, positions_after(live_scene(folder, thrown + after), 40)) < 1e-9);
  CHECK(difference(with_keys, positions_after(live_scene(folder, thrown + before), 40)) > 1e-4);
}

TEST_CASE("gravity takes keys: a body that it leaves flies straight on") {
  const TemporaryFolder folder;
  const Scene scene =
      live_scene(folder, "velocity = [0, 8, 0]\n",
                 "gravity = { keys = [[0, [0, -9.81, 0]], [0.105, [0, 0, 0]]], interpolation = \"hold\" }\n");
  const Simulation simulation = set_up(scene);
  Stepping stepping = begin_stepping(simulation);
  State state = rest_state(simulation.model);
  for (int step = 1; step <= 24; ++step) {
    advance(stepping, {}, state);
    // twelve steps of 1/120 s end before the key
    CHECK(state.velocities.col(1).mean() == Approx(8 - 9.81 * std::min(step, 12) / 120.0).epsilon(1e-9));
  }
}

TEST_CASE("mass follows keys of density and momentum does not come from nowhere") {
  const TemporaryFolder folder;
  Simulation simulation =
      set_up(live_scene(folder, "material.density = { keys = [[0, 500], [0.1, 1500]], interpolation = \"linear\" }\n"));
  const double mass = simulation.model.node_mass.sum();
  CHECK(has_keyed_mass_or_friction(simulation.model));
  CHECK_FALSE(bring_to(simulation.model, 0));
  CHECK(bring_to(simulation.model, 0.05));
  CHECK(simulation.model.node_mass.sum() == Approx(2 * mass));
  CHECK(bring_to(simulation.model, 7));
  CHECK(simulation.model.node_mass.sum() == Approx(3 * mass));
  // by whatever way it came there
  const VectorXd late = simulation.model.node_mass;
  bring_to(simulation.model, 0.033);
  bring_to(simulation.model, 7);
  CHECK(simulation.model.node_mass == late);
  CHECK(bring_to(simulation.model, 0));
  CHECK(simulation.model.node_mass == simulation.model.node_mass_t0);
}

TEST_CASE("keys change the digest of what decides the states, constants do not") {
  const TemporaryFolder folder;
  const Digest constant = set_up(live_scene(folder)).digest;
  CHECK(set_up(live_scene(folder)).digest == constant);
  for (const char* keyed : {"friction = { keys = [[0, 0.5], [1, 0.6]], interpolation = \"hold\" }\n",
                            "material.density = { keys = [[0, 500], [1, 600]], interpolation = \"hold\" }\n",
                            "material.damping_mass = { keys = [[0, 0], [1, 1]], interpolation = \"hold\" }\n"})
    CHECK(set_up(live_scene(folder, keyed)).digest != constant);
  CHECK(set_up(live_scene(folder, "", "gravity = { keys = [[0, [0, -9.81, 0]], [1, [0, 0, 0]]] }\n")).digest !=
        constant);
}

TEST_CASE("a file of pulls that is damaged, or of another scene, is refused") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  REQUIRE(grab(session, {0, 0, {0, 1, 0}}));
  step(session);
  const std::string bytes = encode_pulls(session.pulls, session.simulation.model);
  const Model& model = session.simulation.model;
  const RecordedPulls again = decode_pulls(bytes, "x.pulls", model);
  REQUIRE(again.size() == 1);
  CHECK(again.at(0)[0].body == "block");
  CHECK(again.at(0)[0].place == session.pulls.at(0)[0].place);
  CHECK(again.at(0)[0].weights == session.pulls.at(0)[0].weights);
  const auto fails = [&](const std::string& damaged) {
    const Failure failure = failure_of([&] { decode_pulls(damaged, "x.pulls", model); });
    return failure.code == 65 && failure.where == "x.pulls" && !failure.remedy.empty();
  };
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = char(damaged[i] ^ 1);
    CHECK(fails(damaged));
    CHECK(fails(bytes.substr(0, i)));
  }
  CHECK(fails(bytes + "x"));
  CHECK(failure_of([&] { decode_pulls(bytes, "x.pulls", Model()); }).code == 65);
}
