#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/error_code_of.h"
#include "tools/cli/mesh_scene.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/pictures/shot.h"
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
    CHECK(body.material.density.at(0) * 9.81 * height / body.material.young.at(0) == Approx(500 * 9.81 * 2 / 500e3));
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

TEST_CASE("several meshes are dropped in turn, apart from each other however they are turned") {
  const TemporaryFolder folder;
  const auto tip = write_mesh(folder);
  make_file(folder / "a slab.obj", "v 0 0 0\nv 4 0 0\nv 0 0.5 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  Options options;
  options.cells = 30;
  const Scene scene = scene_of_meshes({tip, folder / "a slab.obj"}, 13, options);
  CHECK(scene.name == "tip-a_slab-13");
  REQUIRE(scene.bodies.size() == 13);
  CHECK(scene.bodies.front().name == "a_slab_1");
  CHECK(scene.bodies.back().name == "tip_7");
  CHECK(scene.clip.frames > 120);

  const Simulation simulation = set_up(scene);
  for (const std::string& warning : simulation.warnings) CHECK(warning.find("starts") == std::string::npos);
  int num_upright = 0, num_shared = 0;
  for (std::size_t a = 0; a < simulation.bodies.size(); ++a) {
    num_upright += scene.bodies[a].rotation_degrees.isZero();
    for (std::size_t b = 0; b < a; ++b) {
      const Points &p = simulation.bodies[a].shape.mesh.positions, &q = simulation.bodies[b].shape.mesh.positions;
      const Eigen::AlignedBox3d box_a(p.colwise().minCoeff().transpose(), p.colwise().maxCoeff().transpose()),
          box_b(q.colwise().minCoeff().transpose(), q.colwise().maxCoeff().transpose());
      CHECK_FALSE(box_a.intersects(box_b));
      num_shared += simulation.bodies[a].embedding == simulation.bodies[b].embedding;
    }
  }
  CHECK(num_upright == 3);
  CHECK(num_shared == 1);  // the seventh tip has the first one's turn
}

TEST_CASE("each of several meshes is dropped once, and they are named after their files") {
  const TemporaryFolder folder;
  const auto tip = write_mesh(folder);
  make_file(folder / "more/tip.obj", file_text(tip));
  make_file(folder / "\xc3\xa4.obj", file_text(tip));
  Options options;
  options.height = "30 cm";
  const Scene scene = scene_of_meshes({tip, folder / "more/tip.obj", folder / "\xc3\xa4.obj"}, 3, options);
  REQUIRE(scene.bodies.size() == 3);
  CHECK(scene.bodies[0].name == "__");
  CHECK(scene.bodies[1].name == "tip_1");
  CHECK(scene.bodies[2].name == "tip_2");
  for (const BodyDescription& body : scene.bodies) CHECK(body.scale == 0.3);
  CHECK(error_code_of([&] { scene_of_meshes({tip, tip}, 1, options); }) == 2);
  CHECK(error_code_of([&] { scene_of_meshes({tip, folder / "none.obj"}, 2, options); }) == 66);
}

TEST_CASE("several meshes without colours of their own are told apart by tones, the first one is of clay") {
  const TemporaryFolder folder;
  const auto tip = write_mesh(folder);
  make_file(folder / "red.obj",
            "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 0 0 1 1 0 0\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const auto color_of = [](const Scene& scene, const std::string& name) {
    const auto found = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                    [&](const BodyDescription& body) { return body.name == name; });
    REQUIRE(found != scene.bodies.end());
    return found->look.base_color;
  };
  const Scene alone = scene_of_height(tip, "1 m"), heap = scene_of_meshes({tip, folder / "red.obj"}, 10, Options());
  const Vector3f clay = alone.bodies.front().look.base_color;
  CHECK(color_of(heap, "tip_1") == clay);
  for (int a = 1; a <= 3; ++a)
    for (int b = 1; b < a; ++b)
      CHECK((color_of(heap, fmt::format("tip_{}", a)) - color_of(heap, fmt::format("tip_{}", b))).norm() > 0.1f);
  for (int n = 1; n <= 5; ++n) CHECK(color_of(heap, fmt::format("red_{}", n)) == Look().base_color);
}

TEST_CASE("an input is a folder, a mesh or a scene") {
  const TemporaryFolder folder;
  CHECK(kind_of_input(folder.path().string()) == InputKind::run);
  CHECK(kind_of_input("dragon.PLY") == InputKind::mesh);
  CHECK(kind_of_input("falls/dragon.toml") == InputKind::scene);
  CHECK(kind_of_input("figure") == InputKind::scene);
}

TEST_CASE("a mesh stands in a studio, outdoors or on white, in proportion to its size") {
  const TemporaryFolder folder;
  const auto mesh = write_mesh(folder);
  Options options;
  const auto staged = [&](const char* stage, const char* height) {
    options.stage = stage;
    options.height = height;
    return scene_of_mesh(mesh, 0, options);
  };
  const Scene studio = staged("studio", "1 m"), sky = staged("sky", "1 m"), plain = staged("plain", "1 m");
  CHECK(scene_of_height(mesh, "1 m").lights.size() == studio.lights.size());
  CHECK(std::holds_alternative<GradientSky>(studio.render.sky));
  CHECK(std::holds_alternative<DaylightSky>(sky.render.sky));
  CHECK(std::holds_alternative<ConstantSky>(plain.render.sky));
  CHECK(plain.render.backdrop.has_value());

  const Scene large = staged("studio", "2 m");
  REQUIRE(studio.obstacles.front().fade.has_value());
  CHECK(*large.obstacles.front().fade == Approx(2 * *studio.obstacles.front().fade));
  // the same light falls on it: power goes with the square of the size
  CHECK(large.lights.front().power.at(0) == Approx(4 * studio.lights.front().power.at(0)));
  CHECK(large.lights.front().position.at(0).x() == Approx(2 * studio.lights.front().position.at(0).x()));

  const Simulation simulation = set_up(large);
  const State state = rest_state(simulation.model);
  const RenderScene shot =
      make_shot(simulation, make_stage(simulation, box_of(simulation, state.positions)), state, Camera());
  REQUIRE(shot.objects.back().fade.has_value());
  CHECK(shot.objects.back().fade->end == Approx(*large.obstacles.front().fade));
}
