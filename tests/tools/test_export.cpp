// umax export: what is written is what the states say, whole or not at all, and where it cannot be, it is said.
#include "tools/exchange/export_clip.h"

#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <cstring>

#include "core/element/rotation.h"
#include "core/files/read_file.h"
#include "embedding/hex_files/hex_mesh_io.h"
#include "embedding/mesh_files/mesh_io.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/exchange/export_files.h"
#include "tools/pictures/hex_stress.h"
#include "tools/run/render_frames.h"

using namespace umax;
using test::contains;
using test::failure_of;
namespace fs = std::filesystem;

namespace {

const std::string plate = R"([obstacle.plate]
shape = "box"
size = [0.3, 0.05, 0.3]
position = { keys = [[0, [0, 0.9, 0]], [0.5, [0, 0.7, 0]]] }
rotation = { keys = [[0, [0, 0, 0]], [0.5, [0, 90, 0]]] }
)";

/// The block's run, simulated once for all tests of the process.
const fs::path& block_run() {
  static const fs::path run = [] {
    const fs::path scene = output_folder() / "block.toml";
    make_file(scene, block_scene(plate));
    REQUIRE(exit_code_of({"simulate", scene.string(), "-o", (output_folder() / "block").string(), "--quiet"}) == 0);
    return output_folder() / "block";
  }();
  return run;
}

const Simulation& block() {
  static const Simulation simulation = set_up(load_scene((block_run() / "scene.toml").string(), {}));
  return simulation;
}

State state_of(int frame) {
  return read_state(state_path(block_run(), frame), block().model, block().digest);
}

/// Where the body's vertices are in a frame.
FloatPoints positions_of(int frame) {
  TriangleMesh mesh;
  deform(*block().bodies[0].embedding, block().bodies[0].lattice.hexes, state_of(frame).positions, mesh);
  return mesh.positions.cast<float>();
}

/// A frame's points of a PC2 file.
FloatPoints read_pc2(const fs::path& path, int index) {
  const std::string bytes = read_file(path);
  int num_vertices = 0, num_frames = 0;
  std::memcpy(&num_vertices, bytes.data() + 16, 4);
  std::memcpy(&num_frames, bytes.data() + 28, 4);
  REQUIRE(bytes.size() == 32 + std::size_t(num_frames) * num_vertices * 12);
  REQUIRE(index < num_frames);
  FloatPoints points(num_vertices, 3);
  std::memcpy(points.data(), bytes.data() + 32 + std::size_t(index) * num_vertices * 12,
              std::size_t(num_vertices) * 12);
  return points;
}

ExportResult export_block(const fs::path& folder, const ExportOptions& options,
                          const std::vector<int>& frames = {1, 6, 11}) {
  Progress quiet(stdout, ProgressMode::plain, true);
  const ClipSource source{.state = state_of, .camera = [] { return camera_of_run(block(), block_run()); }};
  return export_clip(block(), source, frames, folder, options, quiet);
}

double largest_difference(const FloatPoints& a, const FloatPoints& b) {
  REQUIRE(a.rows() == b.rows());
  return double((a - b).cwiseAbs().maxCoeff());
}

ProcessResult export_by_program(const Words& more) {
  return umax_program(Words{"export", block_run().string(), "--quiet"} + more);
}

}  // namespace

TEST_CASE("a cache holds the deformed surface of every frame, to the last bit of single precision") {
  const TemporaryFolder folder;
  const ExportResult result = export_block(folder.path(), {});
  CHECK(result.files ==
        std::vector<fs::path>{folder / "block.pc2", folder / "obstacle.ground.obj", folder / "obstacle.plate.pc2"});
  const FloatPoints first = read_pc2(folder / "block.pc2", 0);
  int index = 0;
  for (const int frame : {1, 6, 11}) CHECK(read_pc2(folder / "block.pc2", index++) == positions_of(frame));
  CHECK(largest_difference(first, read_pc2(folder / "block.pc2", 2)) > 0.02);

  // the mesh beside it is the one at rest, in the same order
  const TriangleMesh rest = load_mesh(folder / "block.obj").mesh;
  CHECK(rest.triangles == block().bodies[0].shape.mesh.triangles);
  CHECK(largest_difference(rest.positions.cast<float>(), first) < 1e-6);
}

TEST_CASE("axes and scale: z up turns, and lengths grow") {
  const TemporaryFolder folder;
  export_block(folder.path(), {.things = {"block"}, .z_up = true, .scale = 100});
  const FloatPoints plain = positions_of(6), turned = read_pc2(folder / "block.pc2", 1);
  for (Eigen::Index v = 0; v < plain.rows(); ++v) {
    const Eigen::RowVector3f wanted(100 * plain(v, 0), -100 * plain(v, 2), 100 * plain(v, 1));
    CHECK((turned.row(v) - wanted).norm() < 1e-4f);
  }
  CHECK(!fs::exists(folder / "obstacle.plate.pc2"));
}

TEST_CASE("obstacles move as they are keyed") {
  const TemporaryFolder folder;
  export_block(folder.path(), {.things = {"obstacle.plate"}});
  CHECK(!fs::exists(folder / "block.pc2"));
  const Points own = block().obstacles[1].mesh->positions;
  for (int i = 0; i < 3; ++i) {
    const double time = (5 * i) / 60.0;
    const double turn = double(EIGEN_PI) / 180 * 90 * time / 0.5;
    const FloatPoints found = read_pc2(folder / "obstacle.plate.pc2", i);
    for (Eigen::Index v = 0; v < own.rows(); ++v) {
      const Vector3d at = own.row(v);
      const Vector3d wanted(std::cos(turn) * at.x() + std::sin(turn) * at.z(), at.y() + 0.9 - 0.2 * time / 0.5,
                            -std::sin(turn) * at.x() + std::cos(turn) * at.z());
      CHECK((found.row(v).cast<double>().transpose() - wanted).norm() < 1e-6);
    }
  }
}

TEST_CASE("a body and an obstacle may have one name, and what is not seen is exported by its name alone") {
  const std::string scene =
      "[body.plate]\nshape = \"box\"\nposition = [0, 2, 0]\ncage.cells = [1, 1, 1]\n"
      "[obstacle.plate]\nshape = \"plane\"\n[obstacle.wall]\nshape = \"box\"\nsize = [1, 1, 1]\nvisible = false\n";
  const Simulation simulation = set_up(parse_scene({.text = scene}, {}));
  const auto stems = [&](const std::vector<std::string>& names) {
    std::vector<std::string> found;
    for (const ExportedThing& thing : things_to_export(simulation, {.things = names})) found.push_back(thing.stem);
    return found;
  };
  CHECK(stems({}) == std::vector<std::string>{"plate", "obstacle.plate"});
  CHECK(stems({"plate"}) == std::vector<std::string>{"plate"});
  CHECK(stems({"obstacle.plate"}) == std::vector<std::string>{"obstacle.plate"});
  CHECK(stems({"wall"}) == std::vector<std::string>{"obstacle.wall"});
  CHECK(failure_of([&] { stems({"walls"}); }).code == 2);
}

TEST_CASE("velocities are what positions change by") {
  const ExportOptions options{.format = ExportFormat::ply, .z_up = true, .scale = 10};
  for (const ExportedThing& thing : things_to_export(block(), options)) {
    if (!thing.surface.moves) continue;
    CAPTURE(thing.stem);
    // in free fall a step changes the velocity by g h: its mean is in the middle
    const SurfaceFrame at = sample(block(), thing, options, 2, state_of(2)),
                       next = sample(block(), thing, options, 3, state_of(3));
    const FloatPoints mean = (next.positions - at.positions) * 60;
    CHECK(largest_difference(mean, (at.velocities + next.velocities) / 2) < 10 * 9.81 / 60);
    CHECK(mean.norm() > 1);
    CHECK((at.normals.rowwise().norm().array() - 1).abs().maxCoeff() < 1e-5f);
  }
}

TEST_CASE("sequences have a file for each frame, and more frames may be added later") {
  const TemporaryFolder folder;
  for (const ExportFormat format : {ExportFormat::obj, ExportFormat::ply}) {
    const std::string ending = traits_of(format).ending;
    export_block(folder.path(), {.format = format}, {2, 4});
    export_block(folder.path(), {.format = format}, {3});
    for (const int frame : {2, 3, 4}) {
      const TriangleMesh mesh = load_mesh(folder / ("block/000" + std::to_string(frame) + "." + ending)).mesh;
      CHECK(mesh.positions.cast<float>() == positions_of(frame));
      CHECK(mesh.triangles == block().bodies[0].shape.mesh.triangles);
    }
    CHECK(fs::exists(folder / ("obstacle.ground." + ending)));
  }
  CHECK(fs::exists(folder / "block/block.mtl"));
}

TEST_CASE("stress and energy of a hex that is stretched and turned are those of Hooke's law") {
  const Vector3d stretch(1.1, 0.95, 1.02);
  const Matrix3d turn = rotation_from_degrees({30, -50, 80});
  State state = rest_state(block().model);
  const Matrix3d rest_turn = rotation_from_degrees({10, 0, 20});  // of the scene's block, whose hexes turn along
  const Matrix3d map = turn * rest_turn * stretch.asDiagonal() * rest_turn.transpose();
  state.positions = (block().model.rest_positions * map.transpose()).eval();
  const HexStress result = hex_stress(block(), state);
  const double young = 20e3, poisson = 0.3, lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)),
               mu = young / (2 * (1 + poisson));
  const Vector3d strain = stretch - Vector3d::Ones();
  const Vector3d principal = Vector3d::Constant(lambda * strain.sum()) + 2 * mu * strain;
  const Matrix3d wanted = turn * rest_turn * principal.asDiagonal() * rest_turn.transpose() * turn.transpose();
  for (Eigen::Index e = 0; e < block().model.num_hexes(); ++e) {
    CHECK((result.stress[std::size_t(e)] - wanted).norm() < 1e-8 * wanted.norm());
    const double volume = block().model.shapes[block().model.hex_shape[e]].volume;
    CHECK(std::abs(result.energy[e] - 0.5 * principal.dot(strain) * volume) < 1e-9 * result.energy[e]);
  }
  CHECK(std::abs(von_mises(Vector3d(0, -7, 0).asDiagonal()) - 7) < 1e-12);
  CHECK(von_mises(5 * Matrix3d::Identity()) < 1e-12);
}

TEST_CASE("cages go to VTK files, with an index of all frames that are there") {
  const TemporaryFolder folder;
  export_block(folder.path(), {.format = ExportFormat::vtu}, {3, 5});
  export_block(folder.path(), {.format = ExportFormat::vtu}, {4});
  const std::string index = read_file(folder / "cages.pvd");
  for (const char* file : {"block/0003.vtu", "block/0004.vtu", "block/0005.vtu"}) {
    CHECK(contains(index, file));
    const HexMesh cage = load_hex_mesh(folder / file);
    CHECK(cage.hexes == block().bodies[0].lattice.hexes);
    CHECK(cage.nodes == state_of(file[9] - '0').positions);
  }
  CHECK(!fs::exists(folder / "obstacle.plate"));
  CHECK(failure_of([&] { export_block(folder.path(), {.format = ExportFormat::vtu, .things = {"plate"}}); }).code == 2);
}

TEST_CASE("files that are there are not replaced unasked") {
  const TemporaryFolder folder;
  export_block(folder.path(), {});
  const std::string before = read_file(folder / "block.pc2");
  const auto failure = failure_of([&] { export_block(folder.path(), {.scale = 2}); });
  CHECK(failure.code == 73);
  CHECK(contains(failure.message, "--overwrite"));
  CHECK(read_file(folder / "block.pc2") == before);
  // another cache shares the mesh at rest as long as it is the same one
  export_block(folder.path(), {.format = ExportFormat::mdd});
  CHECK(failure_of([&] { export_block(folder.path(), {.format = ExportFormat::obj, .scale = 2}); }).code == 73);
  export_block(folder.path(), {.scale = 2, .overwrite = true});
  CHECK(read_file(folder / "block.pc2") != before);
}

TEST_CASE("what cannot be exported says why, and leaves nothing half-written") {
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  const auto refused = [&](const Words& words) { return export_by_program(words + Words{"-o", out}); };
  CHECK(refused({}).exit_code == 2);
  CHECK(contains(refused({}).messages, "--format pc2|mdd"));
  CHECK(refused({"--format", "fbx"}).exit_code == 2);
  CHECK(contains(refused({"--format", "fbx"}).messages, "pc2"));
  CHECK(contains(refused({"--format", "pc2", "--bodies", "blck"}).messages, "did you mean block?"));
  CHECK(refused({"--format", "pc2", "--bodies", "block,"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--up", "x"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--scale", "0"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--frames", "1,2,4"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--frames", "13"}).exit_code == 2);
  CHECK(fs::is_empty(folder.path()));
  CHECK(export_by_program({"--format", "pc2", "-o", "/proc/none"}).exit_code == 73);
  CHECK(umax_program({"export", out, "--format", "pc2"}).exit_code == 66);
}

TEST_CASE("a missing or damaged state ends an export without its files") {
  const TemporaryFolder folder;
  fs::copy(block_run(), folder / "run", fs::copy_options::recursive);
  const fs::path state = state_path(folder / "run", 7);
  const Words words{"export", (folder / "run").string(), "--quiet", "--format", "pc2"};
  std::string bytes = file_text(state);
  bytes[bytes.size() / 2] ^= 1;
  make_file(state, bytes);
  const ProcessResult damaged = umax_program(words);
  CHECK(damaged.exit_code == 65);
  CHECK(contains(damaged.messages, "0007.state"));
  CHECK(!fs::exists(folder / "run/export/block.pc2"));
  CHECK(!has_half_written_files(folder / "run"));
  fs::remove(state);
  // without --frames, all that are there up to the gap
  CHECK(umax_program(words + Words{"--frames", "1-12"}).exit_code == 66);
  CHECK(umax_program(words).exit_code == 0);
  CHECK(fs::file_size(folder / "run/export/block.pc2") ==
        32 + 6 * 12 * std::size_t(block().bodies[0].shape.mesh.num_vertices()));
  for (int frame = 1; frame <= 12; ++frame) fs::remove(state_path(folder / "run", frame));
  CHECK(umax_program(words + Words{"--overwrite"}).exit_code == 66);
}

TEST_CASE("a full disk ends an export without its files") {
  block();
  for (const char* format : {"pc2", "mdd", "abc", "usd", "gltf", "ply", "vtu"}) {
    CAPTURE(format);
    const TemporaryFolder folder;
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{.rlim_cur = 3000, .rlim_max = before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    const auto failure =
        failure_of([&] { export_block(folder.path(), {.format = parse_export_format(format), .things = {"block"}}); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    CHECK(failure.code == 73);
    CHECK(contains(failure.remedy, "free some space"));
    CHECK(!has_half_written_files(folder.path()));
    for (const char* file : {"block.pc2", "block.mdd", "block.abc", "block.usda", "block.gltf", "block.bin"})
      CHECK(!fs::exists(folder / file));
  }
}

TEST_CASE("an export that is asked to stop leaves no file half-written") {
  const TemporaryFolder folder;
  fs::copy(block_run(), folder / "run", fs::copy_options::recursive);
  const fs::path state = state_path(folder / "run", 7);
  fs::rename(state, folder / "state");
  REQUIRE(::mkfifo(state.c_str(), 0600) == 0);  // the program waits here
  const std::string command = std::string(UMAX_PROGRAM) + " export run --format pc2 --quiet & program=$!; sleep 0.5; " +
                              "kill -TERM $program; cat state > run/states/0007.state & wait $program";
  CHECK(run_process({"bash", "-c", "cd " + folder.path().string() + "; " + command}).exit_code == 128 + SIGTERM);
  CHECK(!fs::exists(folder / "run/export/block.pc2"));
  CHECK(!has_half_written_files(folder / "run"));
}

TEST_CASE("the camera that is exported is the one of the pictures") {
  Camera camera;
  camera.position = {1, 2, 3};
  camera.target = {0, 1, 0};
  RenderDescription render;
  render.width = 200;
  render.height = 100;
  const ClipCamera plain = exported_camera(camera, render, {});
  CHECK(plain.position == Vector3d(1, 2, 3));
  CHECK(plain.aspect == 2);
  CHECK(std::abs(plain.focus_distance - std::sqrt(11.0)) < 1e-6);
  const CameraAxes axes = axes_of(plain);
  CHECK(axes.back.isApprox(Vector3d(1, 1, 3).normalized()));
  CHECK(std::abs(axes.right.dot(axes.up)) < 1e-12);
  CHECK(axes.right.cross(axes.up).isApprox(axes.back));
  const ClipCamera turned = exported_camera(camera, render, {.z_up = true, .scale = 10});
  CHECK(turned.position == Vector3d(10, -30, 20));
  CHECK(turned.up == Vector3d(0, 0, 1));
  CHECK(camera_of_run(block(), block_run()).target.norm() < 1);
}

TEST_CASE("a run that is replaced takes its exports along, and nothing else") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  const Words words{"simulate", scene, "-o", run, "--frames", "1-3", "--quiet"};
  CHECK(exit_code_of(words + Words{"--export", "pc2", "--export", "ply"}) == 0);
  CHECK(fs::exists(folder / "run/export/block.pc2"));
  CHECK(fs::exists(folder / "run/export/block/0003.ply"));
  make_file(folder / "run/export/mine.blend", "mine");
  make_file(folder / "run/export/.block.pc2.part-999999999", "left by a killed export");
  CHECK(exit_code_of(words + Words{"--overwrite"}) == 0);
  const auto left = fs::directory_iterator(folder / "run/export");
  CHECK(std::distance(begin(left), end(left)) == 1);
  CHECK(fs::exists(folder / "run/export/mine.blend"));
  // what is asked for cannot be had: before the first step
  CHECK(exit_code_of({"simulate", scene, "-o", run + "2", "--frames", "1,2,4", "--export", "pc2"}) == 2);
  CHECK(!fs::exists(run + "2"));
}

TEST_CASE("a longer run is exported anew when it goes on") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  for (const Words& more : {Words{"--frames", "1-3"}, Words{"--frames", "1-5", "--resume"}})
    CHECK(exit_code_of(Words{"simulate", scene, "-o", run, "--quiet", "--export", "pc2"} + more) == 0);
  CHECK(read_pc2(folder / "run/export/block.pc2", 4).rows() > 0);
}

TEST_CASE("a texture is copied beside the mesh that has it") {
  const TemporaryFolder folder;
  make_file(folder / "quad.obj",
            "mtllib quad.mtl\nv 0 0 0\nv 0.4 0 0\nv 0 0.4 0\nv 0 0 0.4\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n"
            "f 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 3/1 1/2 4/3\n");
  fs::copy_file(fs::path(UMAX_SOURCE_DIR) / "tests/golden/raster_heat_map.png", folder / "skin.png");
  make_file(folder / "quad.mtl", "newmtl m\nmap_Kd skin.png\n");
  const std::string scene =
      write_scene(folder, "[clip]\nframes = 2\n[body.quad]\nmesh = \"quad.obj\"\ncage.cells = [2, 2, 2]\n").string();
  const std::string run = (folder / "run").string();
  REQUIRE(exit_code_of({"simulate", scene, "-o", run, "--quiet", "--export", "mdd", "--export", "obj"}) == 0);
  CHECK(read_file(folder / "run/export/quad.png") == read_file(folder / "skin.png"));
  CHECK(load_mesh(folder / "run/export/quad.obj").materials.at(0).texture == folder / "run/export/quad.png");
  CHECK(load_mesh(folder / "run/export/quad/0002.obj").materials.at(0).texture == folder / "run/export/quad/quad.png");
}
