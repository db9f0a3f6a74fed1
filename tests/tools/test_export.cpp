// umax export: what is written is what the states say.
#include "core/element/rotation.h"
#include "embedding/hex_files/hex_mesh_io.h"
#include "embedding/mesh_files/mesh_io.h"
#include "tests/support/failure.h"
#include "tests/tools/exported_block.h"
#include "tools/pictures/hex_stress.h"

using namespace umax;
using namespace umax::exported_block;
using test::contains;
using test::failure_of;
namespace fs = std::filesystem;

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
