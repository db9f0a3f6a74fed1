// What a live session gives to a scene that has none of it: limits that can be turned down, handles that move pins.
#include "core/model/pins.h"
#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"
#include "tools/live/session.h"
#include "tools/pictures/heat.h"
#include "tools/setup/limit_report.h"

using namespace umax;
using namespace umax::test;

TEST_CASE("a body without a limit is given one while it moves: it begins where the body is stretched most, and holds") {
  const TemporaryFolder folder;
  std::string text = live_scene_text("velocity = [0, -6, 0]\n");
  const std::string limit = "limit.stretch = \"10 %\"\n";
  text.erase(text.find(limit), limit.size());
  make_file(folder / "soft.toml", text);
  Session session(load_scene((folder / "soft.toml").string(), {}));
  const std::size_t key = key_of(session, "body.block.limit.stretch");
  CHECK(session.keys[key].may_be_none);
  CHECK(value_now(session, key) == no_limit);
  CHECK_FALSE(set_key(session, key, 1.1 * no_limit));
  std::vector<std::string> states;
  const auto stretch = [&] {
    return heat_values(session.simulation, session.state, Heatmap::stretch).maxCoeff() / 100;
  };
  while (stretch() < 0.15 && session.state.step < 60) step_often(session, 1, states);
  const double at_first = stretch();
  REQUIRE(at_first > 0.1);
  REQUIRE(set_key(session, key, 0.05));
  CHECK(value_now(session, key) == Approx(1.05 * at_first));
  for (int i = 0; i < 80; ++i) {
    const double before = value_now(session, key);
    step_often(session, 1, states);
    CHECK(session.simulation.scene.bodies[0].limit.value.at(session.state.time) >= before - 0.5 / 120 - 1e-9);
    CHECK((session.last.max_energy_ratio <= 1.001 || session.last.status == StepStatus::infeasible));
    CHECK(session.last.max_energy_ratio > 0);
  }
  CHECK(value_now(session, key) == 0.05);
  CHECK(stretch() <= 0.05 * std::sqrt(1.001) + 1e-6);
  REQUIRE(set_key(session, key, no_limit));
  CHECK(value_now(session, key) == no_limit);
  step_often(session, 6, states);
  CHECK(replayed(session, folder, session.state.step) == states);
}

TEST_CASE("a limit that is there and is never reached moves nothing") {
  const TemporaryFolder folder;
  std::string text = live_scene_text();
  const std::string limit = "limit.stretch = \"10 %\"\n";
  text.erase(text.find(limit), limit.size());
  make_file(folder / "soft.toml", text);
  const Scene scene = load_scene((folder / "soft.toml").string(), {});
  Session session(scene);
  std::vector<std::string> states;
  step_often(session, 40, states);
  const Simulation bare = set_up(scene);
  Stepping stepping = begin_stepping(bare);
  State state = rest_state(bare.model);
  for (int i = 0; i < 40; ++i) advance(stepping, {}, state);
  CHECK((state.positions - session.state.positions).cwiseAbs().maxCoeff() < 1e-7);
}

TEST_CASE("a pin that is moved leads its points at two metres a second, and is simulated again to the last bit") {
  const TemporaryFolder folder;
  Session session(
      live_scene(folder,
                 "pin.low.box = { min = [-9, -9, -9], max = [9, 0.12, 9] }\n"
                 "pin.led.box = { min = [-9, 0.38, -9], max = [9, 9, 9] }\npin.led.follow.position = { keys = [[0, "
                 "[0, 0, 0]], [0.5, [0.1, 0, 0]]], interpolation = \"linear\" }\n"));
  const std::size_t first = session.original.obstacles.size();
  REQUIRE(count_handles(session.original) == first + 2);
  const bool low_is_first = session.original.pins[0].name == "low";
  const std::size_t low = first + (low_is_first ? 0 : 1), led = first + (low_is_first ? 1 : 0);
  CHECK_FALSE(place_handle(session, led, {0, 1, 0}));  // the scene animates it
  CHECK_FALSE(place_handle(session, first + 2, {0, 1, 0}));
  std::vector<std::string> states;
  step_often(session, 6, states);
  const auto place = [&] { return place_at(session.simulation, low, session.state.time); };
  const Vector3d start = place(), goal = start + Vector3d(0, 0.01, -0.06);
  const double before = session.state.positions.col(2).mean();
  REQUIRE(place_handle(session, low, goal));
  for (int i = 0; i < 12; ++i) {
    const Vector3d then = place();
    step_often(session, 1, states);
    CHECK((place() - then).norm() <= 2 * session.simulation.options.time_step * (1 + 1e-9));
  }
  CHECK((place() - goal).norm() < 1e-12);
  // the exact points are where they are told
  const PinDemands demands = session.simulation.model.bodies[0].pins->demands_at(session.state.time);
  REQUIRE(!demands.nodes.empty());
  for (std::size_t i = 0; i < demands.nodes.size(); ++i)
    CHECK((session.state.positions.row(demands.nodes[i]) - demands.places.row(Eigen::Index(i))).norm() < 1e-6);
  CHECK(session.state.positions.col(2).mean() < before - 0.015);
  CHECK(replayed(session, folder, (long long)(states.size())) == states);
  restart(session);
  CHECK((place() - start).norm() < 1e-12);
  std::vector<std::string> again;
  step_often(session, 6, again);
  CHECK(again == std::vector<std::string>(states.begin(), states.begin() + 6));
}
