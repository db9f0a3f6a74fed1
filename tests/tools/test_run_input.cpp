#include <cmath>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/error_code_of.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;

namespace {

/// A tetrahedron 1 unit tall.
std::filesystem::path write_mesh(const TemporaryFolder& folder) {
  make_file(folder / "tip.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  return folder / "tip.obj";
}

Scene scene_of_height(const std::filesystem::path& mesh, const std::string& height) {
  Options options;
  options.height = height;
  return scene_of_mesh(mesh, 0.5, options);
}

}  // namespace

TEST_CASE("a dropped mesh sags by the same share of its height in every size") {
  const TemporaryFolder folder;
  const auto mesh = write_mesh(folder);
  const Scene reference = scene_of_height(mesh, "2 m");
  CHECK(reference.bodies.front().material.young.at(0) == Approx(500e3));
  for (const double height : {0.01, 0.3, 20.0}) {
    const Scene scene = scene_of_height(mesh, std::to_string(height));
    const BodyDescription& body = scene.bodies.front();
    CHECK(body.material.density * 9.81 * height / body.material.young.at(0) == Approx(500 * 9.81 * 2 / 500e3));
    CHECK(body.limit.unit == LimitUnit::stretch);
    CHECK(body.limit.value.at(0) == Approx(0.2));
    // h / sqrt(H) is the same but for rounding, and never coarser than a frame
    const double scaled_step = scene.clip.time_step() / std::sqrt(height / 2);
    CHECK(scaled_step <= 1.06 / 60);
  }
}

TEST_CASE("a dropped mesh starts half its height above the ground") {
  const TemporaryFolder folder;
  const Simulation simulation = set_up(scene_of_height(write_mesh(folder), "1.2 m"));
  const TriangleMesh& placed = simulation.bodies.front().shape.mesh;
  CHECK(placed.positions.col(1).minCoeff() == Approx(0.6));
  CHECK(placed.positions.col(1).maxCoeff() == Approx(1.8));
  CHECK(placed.positions.col(0).minCoeff() == Approx(-placed.positions.col(0).maxCoeff()));
  CHECK(simulation.warnings.empty());
}

TEST_CASE("sizes outside 1 cm to 20 m are refused") {
  const TemporaryFolder folder;
  const auto mesh = write_mesh(folder);
  CHECK(error_code_of([&] { scene_of_height(mesh, "9 mm"); }) == 65);
  CHECK(error_code_of([&] { scene_of_height(mesh, "21 m"); }) == 65);
  CHECK(error_code_of([&] { scene_of_height(mesh, "1 cm"); }) == 0);
}

TEST_CASE("settings of the command line win over what drop chooses") {
  const TemporaryFolder folder;
  Options options;
  options.stretch = "10%";
  options.cells = 100;
  options.settings = {"body.body.material.young=1 MPa", "clip.frames=7"};
  const Scene scene = scene_of_mesh(write_mesh(folder), 0.5, options);
  CHECK(scene.bodies.front().limit.value.at(0) == Approx(0.1));
  CHECK(std::get<int>(scene.bodies.front().cage.size) == 100);
  CHECK(scene.bodies.front().material.young.at(0) == Approx(1e6));
  CHECK(scene.clip.frames == 7);
}

TEST_CASE("an input is a folder, a mesh or a scene") {
  const TemporaryFolder folder;
  CHECK(kind_of_input(folder.path().string()) == InputKind::run);
  CHECK(kind_of_input("dragon.PLY") == InputKind::mesh);
  CHECK(kind_of_input("falls/dragon.toml") == InputKind::scene);
  CHECK(kind_of_input("figure") == InputKind::scene);
}
