// Pins from scene files to steps: bones, paint, animations, and the way from rest to the first frame.
#include "core/model/pins.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/files/read_file.h"
#include "embedding/caches/point_cache.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/run/run_folder.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;
using test::contains;
namespace fs = std::filesystem;

namespace {

/// A bone along x, 1 cm thick and far thinner than a cell, and one across it.
const std::string bones = R"(v -0.3 -0.005 -0.005
v 0.1 -0.005 -0.005
v -0.3 0.005 -0.005
v 0.1 0.005 -0.005
v -0.3 0 0.005
v 0.1 0 0.005
f 1 3 2
f 3 4 2
f 1 2 5
f 2 6 5
f 3 5 4
f 5 6 4
f 1 5 3
f 2 4 6
)";

Points bone_vertices() {
  Points rest(6, 3);
  rest << -0.3, -0.005, -0.005, 0.1, -0.005, -0.005, -0.3, 0.005, -0.005, 0.1, 0.005, -0.005, -0.3, 0, 0.005, 0.1, 0,
      0.005;
  return rest;
}

/// What turns about z and rises, rigidly.
Points led(const Points& rest, double time) {
  const Matrix3d turn = Eigen::AngleAxisd(1.5 * time, Vector3d::UnitZ()).toRotationMatrix();
  return (rest * turn.transpose()).rowwise() + Eigen::RowVector3d(0, 0.3 * time, 0);
}

/// An animation of vertices that are led, over the clip of bar().
void make_cache(const fs::path& path, const Points& rest) {
  const ClipSpace clip{.fps = 60, .frames = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20}};
  PointCacheWriter cache(path, PointCacheKind::mdd, int(rest.rows()), clip);
  for (int frame = 1; frame <= 20; ++frame) {
    SurfaceFrame at;
    at.positions = led(rest, (frame - 1) / 60.0).cast<float>();
    cache.append(at);
  }
  cache.finish();
}

/// A box as a mesh file, and its vertices.
Points make_box(const fs::path& path, const Vector3d& low, const Vector3d& high, bool inside_out = false) {
  Points corners(8, 3);
  std::string text;
  for (int i = 0; i < 8; ++i) {
    corners.row(i) << (i & 4 ? high : low).x(), (i & 2 ? high : low).y(), (i & 1 ? high : low).z();
    text += fmt::format("v {} {} {}\n", corners(i, 0), corners(i, 1), corners(i, 2));
  }
  for (std::array<int, 4> face : {std::array{1, 2, 4, 3}, std::array{5, 7, 8, 6}, std::array{1, 5, 6, 2},
                                  std::array{3, 4, 8, 7}, std::array{1, 3, 7, 5}, std::array{2, 6, 8, 4}}) {
    if (inside_out) std::reverse(face.begin(), face.end());
    text += fmt::format("f {} {} {} {}\n", face[0], face[1], face[2], face[3]);
  }
  make_file(path, text);
  return corners;
}

std::string bar(const std::string& pin) {
  return R"([clip]
frames = 20
fps = 60
[body.bar]
shape = "box"
size = [1, 0.2, 0.2]
cage.cells = [10, 2, 2]
material.young = "100 kPa"
[body.bar.pin.held]
)" + pin +
         R"([probe.end]
body = "bar"
point = [0.5, 0, 0]
)";
}

/// The farthest of a pin's points from where it goes [m].
double miss(const Simulation& simulation, const State& state) {
  const Pin& pin = simulation.model.bodies[0].pins->pins()[0];
  const Points targets = targets_at(pin, state.time),
               places = deform_points(pin.points, simulation.bodies[0].lattice.hexes, state.positions);
  double farthest = 0;
  for (Eigen::Index p = 0; p < targets.rows(); ++p)
    if (std::isinf(pin.stiffness[p])) farthest = std::max(farthest, (places.row(p) - targets.row(p)).norm());
  return farthest;
}

State run(const Simulation& simulation, int steps, double allowed) {
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  for (int i = 0; i < steps; ++i) {
    CHECK(step(simulation.model, simulation.options, workspace, state).status == StepStatus::converged);
    CHECK(miss(simulation, state) < allowed);
  }
  return state;
}

}  // namespace

TEST_CASE("flesh follows bones thinner than a cell within a millionth of a metre, and the rest of it swings") {
  const TemporaryFolder folder;
  make_file(folder / "bones.obj", bones);
  make_cache(folder / "bones.mdd", bone_vertices());
  const fs::path scene = write_scene(folder, bar("inside = \"bones.obj\"\nfollow.cache = \"bones.mdd\"\n"), "bar.toml");
  const Simulation simulation = set_up(load_scene(scene.string()));
  REQUIRE(simulation.bodies[0].notes.size() == 1);
  CHECK(contains(simulation.bodies[0].notes[0], "of where they should go"));
  const State state = run(simulation, 19, 1e-6);
  const Vector3d end = probe_positions(simulation, state.positions)[0];
  CHECK(std::abs(end.x() - 0.5 * std::cos(1.5 * 19 / 60.0)) < 0.1);
  CHECK(end.y() < 0.5 * std::sin(1.5 * 19 / 60.0) + 0.3 * 19 / 60.0 - 0.001);  // it hangs behind
}

TEST_CASE("a bone that reaches out of the flesh holds what of the flesh is in it, and that is said") {
  const TemporaryFolder folder;
  make_cache(folder / "handle.mdd", make_box(folder / "handle.obj", {-0.8, -0.01, -0.01}, {-0.3, 0.01, 0.01}));
  const std::string animated = "inside = \"handle.obj\"\nfollow.cache = \"handle.mdd\"\n",
                    keyed =
                        "inside = \"handle.obj\"\nfollow.rotation = { keys = [[0, [0, 0, 0]], [0.3, [0, 0, 30]]] }\n";
  for (const std::string& pin : {animated, keyed}) {
    const Simulation simulation = set_up(load_scene(write_scene(folder, bar(pin), "bar.toml").string()));
    REQUIRE(simulation.warnings.size() == 1);
    CHECK(contains(simulation.warnings[0], "lie outside of the body's cage"));
    run(simulation, 19, 1e-6);
  }
}

TEST_CASE("all of the flesh between the surfaces of a closed mesh goes with it, though cells are smaller") {
  const TemporaryFolder folder;
  const bool inside_out = GENERATE(false, true);
  const Points corners = make_box(folder / "sleeve.obj", {-0.7, -0.3, -0.2}, {-0.15, 0.3, 0.2}, inside_out);
  make_cache(folder / "sleeve.mdd", corners);
  const Simulation simulation = set_up(load_scene(
      write_scene(folder, bar("inside = \"sleeve.obj\"\nfollow.cache = \"sleeve.mdd\"\n"), "bar.toml").string()));
  const State state = run(simulation, 19, 1e-6);
  const Points &rest = simulation.model.rest_positions, wanted = led(rest, 19 / 60.0);
  int inside = 0;
  for (Eigen::Index n = 0; n < rest.rows(); ++n) {
    if (rest(n, 0) > -0.2 + 1e-9) continue;
    ++inside;
    CHECK((state.positions.row(n) - wanted.row(n)).norm() < 1e-6);
  }
  CHECK(inside == 36);
}

TEST_CASE("an open mesh has nothing between its surfaces") {
  const TemporaryFolder folder;
  make_file(folder / "sheet.obj", "v -0.45 -0.09 0.02\nv -0.2 -0.09 0.02\nv -0.2 0.09 0.02\nf 1 2 3\n");
  const Simulation simulation =
      set_up(load_scene(write_scene(folder, bar("inside = \"sheet.obj\"\n"), "bar.toml").string()));
  const Pin& pin = simulation.model.bodies[0].pins->pins()[0];
  for (Eigen::Index p = 0; p < pin.rest.rows(); ++p) CHECK(pin.rest(p, 2) == Approx(0.02));
}

TEST_CASE("paint tells what is held, what a spring pulls and what is free") {
  const TemporaryFolder folder;
  // a bar of its own, with white, grey and black thirds
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 44\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 82\n"
      "property list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i <= 10; ++i)
    for (const auto& [y, z] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
      const int grey = i <= 3 ? 255 : i <= 6 ? 128 : 0;
      ply += std::to_string(-0.5 + 0.1 * i) + " " + std::to_string(0.1 * y) + " " + std::to_string(0.1 * z);
      for (int c = 0; c < 3; ++c) ply += " " + std::to_string(grey);
      ply += "\n";
    }
  int faces = 0;
  const auto face = [&](int a, int b, int c) {
    ply += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    ++faces;
  };
  for (int i = 0; i < 10; ++i)
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * i + k, b = 4 * i + (k + 1) % 4;
      face(a, a + 4, b), face(b, a + 4, b + 4);
    }
  face(0, 1, 2), face(0, 2, 3);
  CHECK(faces == 82);
  face(40, 42, 41), face(40, 43, 42);
  ply.replace(ply.find("face 82"), 7, "face " + std::to_string(faces));
  make_file(folder / "bar.ply", ply);
  std::string text = bar("map = \"bar.ply\"\n");
  text.replace(text.find("shape = \"box\"\nsize = [1, 0.2, 0.2]\n"), 35, "mesh = \"bar.ply\"\n");
  const Simulation simulation = set_up(load_scene(write_scene(folder, text, "bar.toml").string()));
  const Pin& pin = simulation.model.bodies[0].pins->pins()[0];
  int exact = 0, springs = 0;
  for (const double stiffness : pin.stiffness) ++(std::isinf(stiffness) ? exact : springs);
  CHECK(exact == 16);
  CHECK(springs == 12);
  const State state = run(simulation, 19, 1e-6);
  CHECK(probe_positions(simulation, state.positions)[0].y() < -0.005);
}

TEST_CASE("a pin that cannot be made ends the run before its folder is made, and it is said why") {
  const TemporaryFolder folder;
  make_file(folder / "bones.obj", bones);
  make_file(folder / "far.obj", "v 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\n");
  const auto complaint = [&](const std::string& pin) {
    const ProcessResult result = umax_program(
        {"simulate", write_scene(folder, bar(pin), "bar.toml").string(), "-o", (folder / "run").string(), "--quiet"});
    CHECK(result.exit_code == 65);
    CHECK(contains(result.messages, "body.bar.pin.held"));
    CHECK_FALSE(fs::exists(folder / "run/states"));
    return result.messages;
  };
  CHECK(contains(complaint("box = { min = [3, 3, 3], max = [4, 4, 4] }\n"), "holds no point of the body"));
  CHECK(contains(complaint("map = \"bones.obj\"\n"), "no painted vertices"));
  CHECK(contains(complaint("inside = \"far.obj\"\n"), "outside"));
  make_file(folder / "short.mdd", std::string(8, '\0'));
  CHECK(contains(complaint("inside = \"bones.obj\"\nfollow.cache = \"short.mdd\"\n"), "has 0 frames"));
}

TEST_CASE("clip.preroll leads a body from rest to where its pins are in the first frame") {
  const TemporaryFolder folder;
  const std::string pin =
      "box = { min = [-0.6, -1, -1], max = [-0.3, 1, 1] }\nfollow.position = [0, 0.2, 0]\nfollow.rotation = [90, 0, "
      "0]\n";
  const fs::path scene = write_scene(folder, bar(pin), "bar.toml");
  const Simulation at_once = set_up(load_scene(scene.string()));
  REQUIRE(at_once.warnings.size() == 1);
  CHECK(contains(at_once.warnings[0], "clip.preroll leads it there"));
  const Words words{"simulate", scene.string(),       "-o",     (folder / "run").string(),
                    "--set",    "clip.preroll=0.5 s", "--quiet"};
  REQUIRE(exit_code_of(words) == 0);
  const Simulation simulation = set_up(load_scene((folder / "run/scene.toml").string()));
  CHECK(simulation.warnings.empty());
  CHECK(simulation.digest != at_once.digest);
  const State first = read_state(state_path(folder / "run", 1), simulation.model, simulation.digest);
  CHECK(first.time == 0);
  CHECK(first.step == 0);
  CHECK(miss(simulation, first) < 1e-6);
  CHECK(states_of(folder / "run").size() == 20);
}
