// Animations of other programs as obstacles, from the scene to pictures and back to files.
#include <fmt/format.h>

#include <cstring>
#include <map>

#include "core/files/read_file.h"
#include "core/model/deformation.h"
#include "embedding/caches/mesh_sequence.h"
#include "embedding/caches/point_cache.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/exchange/exported_things.h"
#include "tools/pictures/motion_blur.h"
#include "tools/pictures/shot.h"

using namespace umax;
using test::contains;
using test::failure_of;
namespace fs = std::filesystem;

namespace {

constexpr int num_frames = 7;
constexpr double cache_fps = 10;

/// A box of eight corners, in centimetres and with z up, whose top rises.
FloatPoints box_at(int frame) {
  FloatPoints points(8, 3);
  for (int i = 0; i < 8; ++i)
    points.row(i) << (i & 4 ? 30.0F : -30.0F), (i & 2 ? 30.0F : -30.0F), (i & 1 ? 2.0F * float(frame - 1) : -10.0F);
  return points;
}

Triangles box_triangles() {
  Triangles triangles(12, 3);
  triangles << 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7,
      3;
  return triangles;
}

/// The mesh at rest, its animation as PC2, MDD and a folder, and a scene in which a block lies on it.
struct Animation {
  TemporaryFolder folder;
  Animation() {
    MovingSurface surface;
    surface.name = "lift";
    surface.rest = box_at(1);
    surface.triangles = box_triangles();
    make_file(folder / "lift.obj", "");
    MeshSequenceWriter meshes(folder / "frames", MeshFileKind::obj, surface);
    const ClipSpace clip{.fps = cache_fps, .frames = {1, 2, 3, 4, 5, 6, 7}};
    PointCacheWriter pc2(folder / "lift.pc2", PointCacheKind::pc2, 8, clip),
        mdd(folder / "lift.mdd", PointCacheKind::mdd, 8, clip);
    for (int frame = 1; frame <= num_frames; ++frame) {
      SurfaceFrame at;
      at.frame = frame;
      at.positions = box_at(frame);
      fs::create_directories(folder / "frames");
      meshes.append(at);
      pc2.append(at);
      mdd.append(at);
    }
    pc2.finish();
    mdd.finish();
    fs::copy_file(sequence_file(folder / "frames", 1, "obj"), folder / "lift.obj",
                  fs::copy_options::overwrite_existing);
  }
  /// A frame of the folder again, its faces with other corners.
  void write_frame(int frame, const std::map<int, int>& corners) const {
    MovingSurface surface;
    surface.name = "lift";
    surface.rest = box_at(1);
    surface.triangles = box_triangles();
    for (int& corner : surface.triangles.reshaped()) corner = corners.at(corner);
    SurfaceFrame at;
    at.frame = frame;
    at.positions = box_at(frame);
    MeshSequenceWriter(folder / "frames", MeshFileKind::obj, surface).append(at);
  }
  fs::path scene(const std::string& cache, const std::string& more = {}) const {
    const fs::path path = folder / "lift.toml";
    make_file(path, R"([clip]
frames = 40
fps = 60
[body.block]
shape = "box"
size = [0.2, 0.2, 0.2]
position = [0, 0.1001, 0]
cage.cells = [2, 2, 2]
[obstacle.lift]
shape = "mesh"
mesh = "lift.obj"
unit = "cm"
up = "z"
friction = 0.5
cache = ")" + cache + "\"\n" +
                        more + R"([probe.middle]
body = "block"
point = [0, 0.1, 0]
[render]
size = [32, 18]
samples = 1
denoise = false
shutter = 1
)");
    return path;
  }
};

double top_at(const Simulation& simulation, double time) {
  return obstacle_mesh(simulation, 0, time)->positions.col(1).maxCoeff();
}

}  // namespace

TEST_CASE("PC2, MDD and folders of meshes are the same obstacle, in the mesh's unit and axes") {
  const Animation animation;
  std::vector<Points> middles;
  for (const char* cache : {"lift.pc2", "lift.mdd", "frames"}) {
    const std::string more = std::string(cache) == "frames" ? "cache_fps = 10\n" : "";
    const Simulation simulation = set_up(load_scene(animation.scene(cache, more).string()));
    CHECK(simulation.model.obstacles[0].deformation->motion().times.size() == num_frames);
    CHECK(top_at(simulation, 0) == Approx(0).margin(1e-9));
    CHECK(top_at(simulation, 0.25) == Approx(0.05).margin(1e-7));
    CHECK(top_at(simulation, 9) == Approx(0.12).margin(1e-7));
    middles.push_back(obstacle_mesh(simulation, 0, 0.333)->positions);
  }
  CHECK((middles[0] - middles[1]).cwiseAbs().maxCoeff() < 1e-7);  // MDD's times are floats
  CHECK((middles[0] - middles[2]).cwiseAbs().maxCoeff() < 1e-7);
}

TEST_CASE("a cache of a file's vertices is that of its mesh, be those of no triangle among them or not") {
  const Animation animation;
  const auto middle = [&](const char* cache) {
    return obstacle_mesh(set_up(load_scene(animation.scene(cache).string())), 0, 0.333)->positions;
  };
  const Points expected = middle("lift.pc2");
  // the mesh file gets a vertex before the first and one after the last that no triangle has
  std::string text = "v 99 99 99\n";
  const FloatPoints rest = box_at(1);
  for (const auto& at : rest.rowwise()) text += fmt::format("v {} {} {}\n", at[0], at[1], at[2]);
  text += "v 98 98 98\n";
  const Triangles triangles = box_triangles();
  for (const auto& corners : triangles.rowwise())
    text += fmt::format("f {} {} {}\n", corners[0] + 2, corners[1] + 2, corners[2] + 2);
  make_file(animation.folder / "lift.obj", text);
  PointCacheWriter all(animation.folder / "all.pc2", PointCacheKind::pc2, 10,
                       {.fps = cache_fps, .frames = {1, 2, 3, 4, 5, 6, 7}});
  for (int frame = 1; frame <= num_frames; ++frame) {
    SurfaceFrame at;
    at.frame = frame;
    at.positions = FloatPoints::Constant(10, 3, 90);
    at.positions.middleRows(1, 8) = box_at(frame);
    all.append(at);
  }
  all.finish();
  CHECK(middle("all.pc2") == expected);
  CHECK(middle("lift.pc2") == expected);
}

TEST_CASE("start, speed, offset and frames a second say when an animation plays") {
  const Animation animation;
  const auto top = [&](const std::string& more, double time) {
    return top_at(set_up(load_scene(animation.scene("lift.pc2", more).string())), time);
  };
  CHECK(top("cache_start = 0.2\n", 0.3) == Approx(0.02).margin(1e-7));
  CHECK(top("cache_speed = 2\n", 0.1) == Approx(0.04).margin(1e-7));
  CHECK(top("cache_offset = \"0.3 s\"\n", 0) == Approx(0.06).margin(1e-7));
  CHECK(top("cache_offset = 0.1\ncache_speed = 0.5\ncache_start = 0.1\n", 0.3) == Approx(0.04).margin(1e-7));
  CHECK(top("cache_fps = 20\n", 0.1) == Approx(0.04).margin(1e-7));
}

TEST_CASE("an animated obstacle lifts what lies on it, and is exported and blurred as it moves") {
  const Animation animation;
  const Simulation simulation = set_up(load_scene(animation.scene("lift.pc2").string()));
  Workspace workspace(simulation.model);
  std::vector<State> states{rest_state(simulation.model)};
  for (int i = 0; i < 39; ++i) {
    states.push_back(states.back());
    CHECK(step(simulation.model, simulation.options, workspace, states.back()).status == StepStatus::converged);
  }
  CHECK(probe_positions(simulation, states.back().positions)[0].y() == Approx(0.22).margin(0.01));

  ExportOptions options;
  options.format = ExportFormat::abc;
  const std::vector<ExportedThing> things = things_to_export(simulation, options);
  REQUIRE(things.size() == 2);
  CHECK(things[1].surface.moves);
  const SurfaceFrame frame = sample(simulation, things[1], options, 19, states[18]);
  CHECK(frame.positions.col(1).maxCoeff() == Approx(0.06).margin(1e-6));
  CHECK(frame.velocities.col(1).maxCoeff() == Approx(0.2).margin(1e-3));
  CHECK(frame.velocities.col(1).minCoeff() == Approx(0).margin(1e-3));

  const Stage stage = make_stage(simulation, box_of(simulation, states[18].positions));
  RenderScene shot = make_shot(simulation, stage, states[18], Camera());
  CHECK(shot.objects[1].mesh->positions.col(1).maxCoeff() == Approx(0.06).margin(1e-7));
  const Exposure exposure = exposure_of(simulation.scene.render, 19, 40);
  add_motion(simulation, stage, {states[17], states[18], states[19]}, exposure, 19, shot);
  const SurfaceMotion& lift = shot.objects[1].motion;
  REQUIRE(lift.instants.size() >= 2);
  const auto top_of = [](const auto& mesh) { return mesh->positions.col(1).maxCoeff(); };
  CHECK(top_of(lift.instants.front()) == Approx(0.2 * 17.5 / 60).margin(1e-6));
  CHECK(top_of(lift.instants.back()) == Approx(0.2 * 18.5 / 60).margin(1e-6));
}

TEST_CASE("a run is told from one with another animation by its bytes") {
  const Animation animation;
  const fs::path scene = animation.scene("lift.pc2"), run = animation.folder / "run";
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", run.string(), "--frames", "1-3", "--quiet"}) == 0);
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", run.string(), "--resume", "--frames", "1-4", "--quiet"}) ==
          0);
  std::string bytes = read_file(animation.folder / "lift.pc2");
  bytes[bytes.size() - 3] ^= 1;
  make_file(animation.folder / "lift.pc2", bytes);
  const ProcessResult other = umax_program({"simulate", scene.string(), "-o", run.string(), "--resume", "--quiet"});
  CHECK(other.exit_code == 65);
  const ProcessResult resolved =
      umax_program({"simulate", (run / "scene.toml").string(), "-o", (animation.folder / "again").string(), "--quiet"});
  CHECK(resolved.exit_code == 65);
  CHECK(contains(resolved.messages, "obstacle.lift.cache_sha256"));
}

TEST_CASE("an animation that cannot be played ends a run before its folder is made") {
  const Animation animation;
  const std::string whole = read_file(animation.folder / "lift.pc2");
  const auto complaint = [&](const std::string& cache, const std::string& more = {}) {
    const fs::path run = animation.folder / "run";
    const ProcessResult result =
        umax_program({"simulate", animation.scene(cache, more).string(), "-o", run.string(), "--quiet"});
    CHECK(result.exit_code == 65);
    CHECK_FALSE(fs::exists(run / "states"));
    return result.messages;
  };
  make_file(animation.folder / "cut.pc2", whole.substr(0, whole.size() - 10));
  CHECK(contains(complaint("cut.pc2"), "is cut off"));
  make_file(animation.folder / "text.txt", "x");
  CHECK(contains(complaint("text.txt"), "is no animation by its name"));
  CHECK(contains(complaint("lift.pc2", "cache_spead = 2\n"), "did you mean obstacle.lift.cache_speed?"));
  fs::remove(sequence_file(animation.folder / "frames", 4, "obj"));
  CHECK(contains(complaint("frames"), "frame 4 is missing"));
  make_file(sequence_file(animation.folder / "frames", 4, "obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  CHECK(contains(complaint("frames"), "has 3 vertices, but the mesh has 8"));
  // as many vertices in another order
  animation.write_frame(4, {{0, 1}, {1, 0}, {2, 2}, {3, 4}, {4, 6}, {5, 7}, {6, 5}, {7, 3}});
  const std::string other = complaint("frames");
  CHECK(contains(other, "0004.obj: has as many vertices as the mesh, but other faces"));
  CHECK(contains(other, "give the mesh that was animated"));
}

TEST_CASE("what a user should know of an animation is said") {
  const Animation animation;
  const auto warnings = [&](const std::string& cache, const std::string& more = {}) {
    std::string all;
    for (const std::string& warning : set_up(load_scene(animation.scene(cache, more).string())).warnings)
      all += warning + "\n";
    return all;
  };
  CHECK(warnings("lift.pc2").empty());
  CHECK(contains(warnings("lift.pc2", "cache_speed = 60\n"), "cells in a step"));
  CHECK(contains(warnings("lift.pc2", "cache_start = 5\n"), "it does not move"));
  // corners 0 and 3 in the place of 1 and 2: the mirrored box, whose faces are cut along their other diagonals
  CHECK(warnings("frames").empty());
  animation.write_frame(3, {{0, 1}, {1, 0}, {2, 3}, {3, 2}, {4, 5}, {5, 4}, {6, 7}, {7, 6}});
  CHECK(contains(warnings("frames"), "0003.obj has 78 % of its edges in common with the mesh"));
  // without its top it is a sheet
  std::string obj = read_file(animation.folder / "lift.obj");
  obj.resize(obj.rfind("\nf "));
  obj.resize(obj.rfind("\nf ") + 1);
  make_file(animation.folder / "lift.obj", obj);
  CHECK(contains(warnings("lift.pc2"), "its mesh is open: both of its sides push, as a sheet of 0.006 m"));
  CHECK_FALSE(contains(warnings("lift.pc2", "thickness = 0.01\n"), "open"));
}
