#include "tools/live/session.h"

#include "core/model/pins.h"
#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tools/pictures/heat.h"
#include "tools/setup/limit_report.h"

using namespace umax;
using namespace umax::test;

namespace {

double height(const Session& session) {
  return session.state.positions.col(1).mean();
}

Grab top_corner(const Session& session) {
  Eigen::Index vertex = 0;
  session.simulation.bodies[0].shape.mesh.positions.col(1).maxCoeff(&vertex);
  const Vector3d at = session.simulation.bodies[0].shape.mesh.positions.row(vertex).transpose();
  return {0, int(vertex), at + Vector3d(0.1, 0.5, 0)};
}

/// A change of each key, a pull, more changes.
void play(Session& session, std::vector<std::string>& states) {
  const auto set = [&](const char* key, double value) { CHECK(set_key(session, key_of(session, key), value)); };
  step_often(session, 5, states);
  set("body.block.limit.stretch", 0.08);
  set("body.block.material.young", 35e3);
  step_often(session, 3, states);
  set("body.block.material.density", 900);
  set("body.block.friction", 0.05);
  CHECK(grab(session, top_corner(session)));
  step_often(session, 6, states);
  set("clip.gravity", 3.7);
  set("body.block.material.damping_mass", 2.5);
  step_often(session, 4, states);
  release(session);
  set("body.block.material.damping_stiffness", 0.003);
  set("body.block.limit.stretch", 0.2);
  step_often(session, 8, states);
}

}  // namespace

TEST_CASE("a key that is set acts from the next step on, in scene and model alike") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  const std::size_t key = key_of(session, "body.block.material.young");
  step(session);
  const double time = session.state.time;
  REQUIRE(set_key(session, key, 50e3));
  CHECK(value_now(session, key) == 50e3);
  step(session);
  for (const Track<double>& track :
       {session.simulation.scene.bodies[0].material.young, session.simulation.model.bodies[0].material.young}) {
    CHECK(track.interpolation == Interpolation::hold);
    CHECK(track.at(time) == 20e3);
    CHECK(track.at(session.state.time) == 50e3);
  }
}

TEST_CASE("values out of range, and keys that are not there, are refused") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  const std::size_t limit = key_of(session, "body.block.limit.stretch");
  CHECK_FALSE(set_key(session, session.keys.size(), 1));
  for (const double value : {0.0, -1.0, 2.0, double(NAN), double(INFINITY)})
    CHECK_FALSE(set_key(session, limit, value));
  CHECK(value_now(session, limit) == 0.1);
}

TEST_CASE("what the scene animates is not turned") {
  const TemporaryFolder folder;
  Session session(live_scene(folder, "material.damping_mass = { keys = [[0, 0], [1, 5]] }\n"));
  const std::size_t key = key_of(session, "body.block.material.damping_mass");
  CHECK(session.keys[key].is_animated);
  CHECK_FALSE(set_key(session, key, 1));
}

TEST_CASE("a limit that is pulled down falls by half a stretch in a second, its goal kept, and rises at once") {
  const TemporaryFolder folder;
  const std::string limit = GENERATE("", "limit.energy = 0.5\n", "limit.density = 60\n");
  std::string text = live_scene_text();
  if (!limit.empty()) text.replace(text.find("limit.stretch"), std::string("limit.stretch = \"10 %\"\n").size(), limit);
  make_file(folder / "block.toml", text);
  Session session(load_scene((folder / "block.toml").string(), {}));
  const LiveKey& key = session.keys[0];
  REQUIRE(key.kind == LiveKind::limit);
  const auto stretch = [&](double value) {
    return stretch_of_limit(session.simulation.scene.bodies[0], EnergyPart::whole, value, 0,
                            mean_hex_volume(session.simulation.bodies[0].lattice));
  };
  step(session);
  const double before = value_now(session, 0), goal = before / 16, h = session.simulation.options.time_step;
  const double reached = stretch(before) - stretch(goal);
  REQUIRE(reached > 3 * 0.5 * h);
  REQUIRE(set_key(session, 0, goal));
  CHECK(session.goals[0] == goal);
  CHECK(value_now(session, 0) == before);
  for (double last = before; last != goal; last = value_now(session, 0)) {
    step(session);
    const double now = key.value_at(session.simulation.scene, session.state.time);
    CHECK(now < last);
    CHECK(stretch(last) - stretch(now) <= 0.5 * h * (1 + 1e-9));
    if (now != goal) CHECK(stretch(last) - stretch(now) == Approx(0.5 * h).epsilon(1e-6));
    last = now;
    if (now == goal) break;
  }
  CHECK(double(session.state.step - 1) == Approx(std::ceil(reached / (0.5 * h))).margin(1));
  REQUIRE(set_key(session, 0, before));
  CHECK(value_now(session, 0) == before);
}

TEST_CASE("a session that is saved and simulated again has the same states to the last bit") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  std::vector<std::string> states;
  play(session, states);
  CHECK(session.pulls.size() == 10);
  CHECK(replayed(session, folder, (long long)(states.size())) == states);
}

TEST_CASE(
    "another cage starts again with the values of the moment, and the session is simulated again to the last bit") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  std::vector<std::string> states;
  play(session, states);
  REQUIRE(set_cells(session, 0, 27));
  const int hexes = session.simulation.model.bodies[0].num_hexes;
  CHECK(hexes > 15);
  CHECK(session.state.step == 0);
  CHECK(session.rows.empty());
  CHECK(session.pulls.empty());
  CHECK(value_now(session, key_of(session, "body.block.material.young")) == 35e3);
  CHECK(value_now(session, key_of(session, "clip.gravity")) == 3.7);
  CHECK(contains(scene_lines(session), "body.block.cage.cells = 27\n"));
  states.clear();
  play(session, states);
  CHECK(replayed(session, folder, (long long)(states.size())) == states);
  for (const int cells : {0, -1, most_live_cells + 1}) CHECK_FALSE(set_cells(session, 0, cells));
  CHECK_FALSE(set_cells(session, 1, 27));
  CHECK_FALSE(set_cells(session, -1, 27));
  session.original.bodies[0].cage.size = MeshSource{};
  CHECK_FALSE(can_set_cells(session, 0));
  CHECK(session.simulation.model.bodies[0].num_hexes == hexes);
}

TEST_CASE("a cage that cannot be made leaves the session as it is") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  std::vector<std::string> states;
  step_often(session, 6, states);
  MeshSource gone;
  gone.path = folder / "gone.obj";
  session.original.bodies[0].source = gone;
  CHECK(failure_of([&] { set_cells(session, 0, 27); }).code == 66);
  CHECK(session.simulation.model.num_hexes() == 8);
  CHECK(bytes_of(session.state) == states.back());
}

TEST_CASE("a session of two bodies with pins is simulated again to the last bit") {
  const TemporaryFolder folder;
  Session session(live_scene(
      folder,
      "pin.low.box = { min = [-9, -9, -9], max = [9, 0.12, 9] }\npin.low.stiffness = 500\n[body.other]\nshape = "
      "\"box\"\nsize = [0.3, 0.3, 0.3]\nposition = [0.6, 0.3, 0]\n"
      "cage.cells = [2, 2, 2]\nlimit.stretch = \"10 %\"\n"));
  std::vector<std::string> states;
  play(session, states);
  CHECK(replayed(session, folder, (long long)(states.size())) == states);
}

TEST_CASE("restarting keeps the values of the moment, from the first step on") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  std::vector<std::string> first, again;
  play(session, first);
  restart(session);
  CHECK(session.state.step == 0);
  CHECK(session.pulls.empty());
  CHECK(session.rows.empty());
  CHECK(bytes_of(session.state) == bytes_of(rest_state(session.simulation.model)));
  CHECK(value_now(session, key_of(session, "body.block.limit.stretch")) == 0.2);
  CHECK(value_now(session, key_of(session, "body.block.material.density")) == 900);
  step_often(session, 12, again);
  CHECK(again.front() != first.front());
  CHECK(replayed(session, folder, 12) == again);
}

TEST_CASE("going on from a frame before forgets what came later, and is simulated again to the last bit") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  std::vector<std::string> states;
  step_often(session, 8, states);
  const State then = session.state;
  REQUIRE(set_key(session, key_of(session, "body.block.material.young"), 90e3));
  REQUIRE(grab(session, top_corner(session)));
  std::vector<std::string> dropped;
  step_often(session, 6, dropped);
  release(session);
  REQUIRE(set_key(session, key_of(session, "clip.gravity"), 2));
  rewind(session, then);
  CHECK(session.pulls.empty());
  CHECK(session.rows.size() == 8);
  step_often(session, 6, states);
  CHECK(states.back() != dropped.back());
  CHECK(replayed(session, folder, (long long)(states.size())) == states);
}

TEST_CASE("a pull lifts the body, and letting go lets it fall") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  std::vector<std::string> states;
  step_often(session, 60, states);
  const double low = height(session);
  REQUIRE(grab(session, top_corner(session)));
  step_often(session, 120, states);
  CHECK(height(session) > low + 0.2);
  release(session);
  const double high = height(session);
  step_often(session, 40, states);
  CHECK(height(session) < high - 0.2);
  CHECK(session.last.status == StepStatus::converged);
}

TEST_CASE(
    "an obstacle that is moved goes there at two metres a second, pushes, and is simulated again to the last bit") {
  const TemporaryFolder folder;
  Session session(
      live_scene(folder, "[obstacle.fist]\nshape = \"box\"\nsize = [0.2, 0.2, 0.6]\nposition = [-0.6, 0.15, 0]\n"));
  REQUIRE(session.original.obstacles[0].name == "fist");
  CHECK_FALSE(place_handle(session, 1, {0, 1, 0}));  // the ground
  CHECK_FALSE(place_handle(session, 2, {0, 1, 0}));
  CHECK_FALSE(place_handle(session, 0, {0, double(NAN), 0}));
  std::vector<std::string> states;
  step_often(session, 10, states);
  const auto fist = [&](double time) { return session.simulation.model.obstacles[0].position.at(time).x(); };
  const double before = session.state.positions.col(0).mean();
  REQUIRE(place_handle(session, 0, {-0.1, 0.15, 0}));
  for (int i = 0; i < 40; ++i) {
    const double then = fist(session.state.time);
    step_often(session, 1, states);
    CHECK(fist(session.state.time) - then <= 2 * session.simulation.options.time_step * (1 + 1e-9));
  }
  CHECK(fist(session.state.time) == -0.1);
  CHECK(session.state.positions.col(0).mean() > before + 0.1);
  CHECK(replayed(session, folder, (long long)(states.size())) == states);
  restart(session);
  CHECK(fist(0.1) == -0.6);
}

TEST_CASE("hard limits hold while a body is dragged about faster than it can follow") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  Grab hand = top_corner(session);
  for (int i = 0; i < 80; ++i) {
    hand.goal = Vector3d(3 * std::sin(0.7 * i), 1 + std::cos(0.9 * i), 2 * std::sin(1.1 * i));
    REQUIRE(grab(session, hand));
    const StepReport& report = step(session);
    if (report.status == StepStatus::converged)
      CHECK(report.max_energy_ratio <= 1 + session.simulation.options.solver.tolerance);
  }
  CHECK(session.state.positions.allFinite());
  CHECK(session.steps_not_converged < 8);
}

TEST_CASE("steps that did not converge are counted though their rows are no longer kept") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  session.most_rows = 4;
  for (int i = 0; i < 8; ++i) step(session);
  const State kept = session.state;
  REQUIRE(session.steps_not_converged == 0);
  session.steps_not_converged = 3;  // as if three of the rows that are gone had been such steps
  step(session);
  session.rows.back().report.status = StepStatus::iteration_limit;
  ++session.steps_not_converged;
  rewind(session, kept);
  CHECK(session.steps_not_converged == 3);
  restart(session);
  CHECK(session.steps_not_converged == 0);
}

TEST_CASE("bodies, vertices and places that are not there cannot be grabbed") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  const int count = int(session.simulation.bodies[0].embedding->hex.size());
  CHECK_FALSE(grab(session, {1, 0, {0, 0, 0}}));
  CHECK_FALSE(grab(session, {-1, 0, {0, 0, 0}}));
  CHECK_FALSE(grab(session, {0, count, {0, 0, 0}}));
  CHECK_FALSE(grab(session, {0, -1, {0, 0, 0}}));
  CHECK_FALSE(grab(session, {0, 0, {double(NAN), 0, 0}}));
  CHECK_FALSE(grab(session, {0, 0, {1e9, 0, 0}}));
  CHECK(grab(session, {0, count - 1, {0, 0, 0}}));
}

TEST_CASE("lines for a scene file tell what has been changed and nothing else") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  CHECK(scene_lines(session).empty());
  REQUIRE(set_key(session, key_of(session, "body.block.material.young"), 35e3));
  REQUIRE(set_key(session, key_of(session, "clip.gravity"), 1.62));
  CHECK(scene_lines(session) == "body.block.material.young = 35000\nclip.gravity = [0, -1.62, 0]\n");
}

TEST_CASE("scenes that a live session cannot run are refused with the remedy") {
  const TemporaryFolder folder;
  const Failure preroll = failure_of([&] { Session session(live_scene(folder, "", "preroll = 0.1\n")); });
  CHECK(preroll.code == 65);
  CHECK(contains(preroll.message, "clip.preroll"));
  CHECK(contains(preroll.remedy, "clip.preroll=0"));
}
