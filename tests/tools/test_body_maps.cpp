// Maps on bodies: where they lie, what they do, and what the program says of them.
#include "tools/setup/body_maps.h"

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/step/step.h"
#include "embedding/surface/shapes.h"
#include "render/image/image_io.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/vdb_files.h"
#include "tests/tools/hex_bar.h"
#include "tests/tools/painted_files.h"
#include "tests/tools/program.h"
#include "tools/pictures/heat.h"
#include "tools/pictures/map_picture.h"

using namespace umax;
using namespace umax::testing;

namespace {

Simulation simulation_of(const TemporaryFolder& folder, const std::string& text) {
  return set_up(load_scene(write_scene(folder, text).string()));
}

bool has_warning(const Simulation& simulation, const std::string& part) {
  return std::any_of(simulation.warnings.begin(), simulation.warnings.end(),
                     [&](const std::string& warning) { return warning.find(part) != std::string::npos; });
}

/// A box whose vertices have the code color(position) in all channels.
template <class ColorAt>
TriangleMesh painted_box(const Vector3d& size, ColorAt color) {
  TriangleMesh mesh = make_box(size);
  mesh.colors.resize(mesh.num_vertices(), 3);
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v)
    mesh.colors.row(v).setConstant(color(Vector3d(mesh.positions.row(v).transpose())));
  return mesh;
}
double dark_at_the_left(const Vector3d& p) {
  return p.x() < 0 ? 0 : 1;
}

/// A bar along x that is held in its middle and bends under its weight on both sides.
std::string held_bar(const std::string& more) {
  return R"([clip]
frames = 4
[body.bar]
mesh = "bar.ply"
cage.cells = [12, 1, 1]
material.young = "60 kPa"
material.damping_mass = 2
limit.stretch = "8 %"
fixed = [{ min = [-0.01, -1, -1], max = [0.01, 1, 1] }]
)" + more +
         R"([render]
size = [32, 18]
samples = 1
denoise = false
[probe.left]
body = "bar"
point = [-0.6, 0, 0]
[probe.right]
body = "bar"
point = [0.6, 0, 0]
)";
}
void write_held_bar(const TemporaryFolder& folder) {
  make_file(folder / "bar.ply", painted_ply(painted_box({1.2, 0.1, 0.1}, dark_at_the_left)));
}

}  // namespace

TEST_CASE("a map stays where it lies on the mesh, however the body is placed") {
  const TemporaryFolder folder;
  const auto field = [](const Vector3d& p) { return 2 + 0.01 * p.x() - 0.004 * p.y() + 0.012 * p.z(); };
  test::write_vdb(folder / "field.vdb",
                  {{.number = field, .voxel = 5, .first = {-14, -14, -14}, .last = {14, 14, 14}}});
  make_file(folder / "cage.msh", gmsh_2(document_of(make_box_lattice({4, 4, 4}, {-60, -60, -60}, {30, 30, 30})), true));
  make_file(folder / "ball.obj", [] {
    TriangleMesh ball = make_sphere(50, 3);
    ball.colors = (ball.positions.array() / 100 + 0.5).matrix();
    return painted_obj(ball);
  }());
  const std::string body = R"(
[body.ball]
mesh = "ball.obj"
cage.mesh = "cage.msh"
limit.stretch = "10 %"
limit.map = "field.vdb"
material.young_map = "ball.obj"
)";
  const Simulation plain = simulation_of(folder, body);
  const Simulation placed = simulation_of(folder, body + R"(
unit = "cm"
up = "z"
height = "3 m"
rotation = [10, 20, 30]
drop_height = "1 m"
[obstacle.ground]
shape = "plane"
)");
  const Simulation moved = simulation_of(folder, body + "scale = 0.02\nrotation = [0, 90, 0]\nposition = [7, 8, 9]\n");
  CHECK(plain.model.limit_factor.maxCoeff() > 2.4);
  CHECK(plain.model.young_factor.maxCoeff() > 1.5 * plain.model.young_factor.minCoeff());
  for (const Simulation* other : {&placed, &moved}) {
    CHECK((plain.model.limit_factor - other->model.limit_factor).cwiseAbs().maxCoeff() < 0.02);
    CHECK((plain.model.young_factor - other->model.young_factor).cwiseAbs().maxCoeff() < 1e-3);
    CHECK(other->model.rest_positions.maxCoeff() < 15);
  }
  CHECK(plain.digest != placed.digest);
}

TEST_CASE("colours are linear in glTF and sRGB in PLY and OBJ") {
  const TemporaryFolder folder;
  const TriangleMesh half = painted_box({0.8, 0.8, 0.8}, [](const Vector3d&) { return 0.5; });
  make_file(folder / "half.gltf", painted_gltf(half));
  make_file(folder / "half.ply", painted_ply(half));
  make_file(folder / "half.obj", painted_obj(half));
  const auto factor_of = [&](const std::string& file) {
    const Simulation simulation = simulation_of(folder, R"([body.box]
shape = "box"
size = [0.8, 0.8, 0.8]
cage.cells = [3, 3, 3]
limit.stretch = 0.1
limit.map_range = [1, 2]
limit.map = ")" + file + "\"\n");
    CHECK(simulation.warnings.empty());
    const VectorXd& factors = simulation.model.limit_factor;
    CHECK(factors.maxCoeff() - factors.minCoeff() < 1e-6);
    return factors[0];
  };
  CHECK(factor_of("half.gltf") == Approx(1.5).epsilon(1e-6));
  CHECK(factor_of("half.obj") == Approx(1.21404).epsilon(1e-5));  // sRGB 0.5 is 0.21404
  CHECK(factor_of("half.ply") == Approx(1.21586).epsilon(1e-5));  // 128 of 255
}

TEST_CASE("a map multiplies the factors that a file of hexes brings") {
  const TemporaryFolder folder;
  make_file(folder / "bar.vtu", vtu(document_of(twisted_bar()), {.format = "binary"}));
  test::write_vdb(folder / "three.vdb", {{.number = [](const Vector3d&) { return 3.0; }, .voxel = 0.06}});
  const Simulation simulation =
      simulation_of(folder, "[body.bar]\nmesh = \"bar.vtu\"\nlimit.stretch = \"5 %\"\nlimit.map = \"three.vdb\"\n");
  for (const Eigen::Index e : {0, 7, 31})
    CHECK(simulation.model.limit_factor[e] == Approx(3 * (1 + 0.25 * double(e))).epsilon(1e-6));
  CHECK(simulation.model.young_factor == VectorXd::Ones(32));
}

TEST_CASE("the painted half of a bar keeps its tighter limit, and the other half stretches further") {
  const TemporaryFolder folder;
  write_held_bar(folder);
  const Simulation simulation = simulation_of(folder, held_bar("limit.map = \"mesh\"\nlimit.map_range = [0.1, 1]\n"));
  CHECK(simulation.model.limit_factor.head(5).maxCoeff() == Approx(0.1).epsilon(1e-9));
  CHECK(simulation.model.limit_factor.tail(5).minCoeff() == Approx(1).epsilon(1e-9));

  Simulation measured = simulation;
  measured.scene.render.heatmap = Heatmap::stretch;
  const double painted = 8 * std::sqrt(0.1);  // [%] the limit is on the energy
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  double most_painted = 0, most_plain = 0;
  for (int i = 0; i < 120; ++i) {
    CHECK(step(simulation.model, simulation.options, workspace, state).status == StepStatus::converged);
    const VectorXd stretches = heat_values(measured, state);
    most_painted = std::max(most_painted, stretches.head(5).maxCoeff());
    most_plain = std::max(most_plain, stretches.tail(5).maxCoeff());
    CHECK(energy_ratios(simulation.model, simulation.options.solver, state).maxCoeff() <= 1.001);
  }
  CHECK(most_painted <= painted * std::sqrt(1.001));
  CHECK(most_painted >= painted * 0.99);
  CHECK(most_plain <= 8 * std::sqrt(1.001));
  CHECK(most_plain > 2 * painted);
  const auto tips = probe_positions(simulation, state.positions);
  CHECK(tips[1].y() < 2 * tips[0].y());  // both hang down
}

TEST_CASE("a map of directions turns with the body, and a limit on the fibre acts along it") {
  const TemporaryFolder folder;
  const auto along_y = [](const Vector3d& p) { return Vector3d(0, p.x() > 0 ? 2 : -1, 0); };
  test::write_vdb(
      folder / "fibre.vdb",
      {{.name = "other", .number = [](const Vector3d&) { return 1.0; }},
       {.name = "fibre", .direction = along_y, .voxel = 0.05, .first = {-12, -12, -12}, .last = {12, 12, 12}}});
  const std::string body = R"([body.block]
shape = "box"
size = [0.8, 0.8, 0.8]
cage.cells = [2, 2, 2]
material.young = "50 kPa"
limit.fibre.direction_map = "fibre.vdb"
)";
  const Simulation plain = simulation_of(folder, body + "limit.fibre.stretch = 0.02\n");
  const Simulation turned = simulation_of(folder, body + "limit.fibre.stretch = 0.02\nrotation = [0, 0, 90]\n");
  CHECK(plain.warnings.empty());
  for (Eigen::Index e = 0; e < 8; ++e) {
    CHECK(std::abs(plain.model.fibre_directions(e, 1)) == Approx(1));
    CHECK(std::abs(turned.model.fibre_directions(e, 0)) == Approx(1));
  }
  CHECK(plain.digest != turned.digest);
  CHECK(has_warning(simulation_of(folder, body), "body.block.limit.fibre.direction_map: the body has no limit on its"));
  const std::string scene = write_scene(folder, body).string(), key = "body.block.limit.fibre.direction_map=";
  make_file(folder / "paint.ply", "ply");
  CHECK(exit_code_of({"inspect", scene, "--set", key + (folder / "paint.ply").string()}) == 65);
  CHECK(exit_code_of({"inspect", scene, "--set", "body.block.limit.fibre.direction_map_grid=other"}) == 65);
  CHECK(exit_code_of({"inspect", scene, "--set", "body.block.limit.fibre.direction_map_grid=fibre"}) == 0);
}

TEST_CASE("what a map leaves out or clamps is said, and a map without a limit too") {
  const TemporaryFolder folder;
  const auto field = [](const Vector3d& p) { return p.x() > 0 ? 5000.0 : 1.0; };
  test::write_vdb(folder / "half.vdb", {{.number = field, .voxel = 0.05, .first = {-3, -9, -9}, .last = {9, 9, 9}}});
  const std::string box = R"([body.box]
shape = "box"
size = [0.8, 0.8, 0.8]
cage.cells = [4, 4, 4]
limit.map = "half.vdb"
)";
  const Simulation simulation = simulation_of(folder, box + "limit.stretch = 0.1\n");
  CHECK(
      has_warning(simulation, "body.box.limit.map: 16 of 64 hexes lie outside the map and keep the body's own value"));
  CHECK(has_warning(simulation, "body.box.limit.map: the map's values of 32 hexes"));
  CHECK_FALSE(has_warning(simulation, "no limit"));
  CHECK(has_warning(simulation_of(folder, box), "body.box.limit.map: the body has no limit"));
}

TEST_CASE("umax says what is wrong with a map: body, key, file, remedy") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene("[camera]\nvertical_fov = 30\n")).string();
  make_file(folder / "damaged.vdb", "not OpenVDB at all");
  make_file(folder / "plain.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  const auto failure = [&](const std::string& map) {
    return umax_program({"inspect", scene, "--set", "body.block.limit.map=" + map});
  };
  const ProcessResult missing = failure((folder / "no.ply").string()),
                      damaged = failure((folder / "damaged.vdb").string()),
                      plain = failure((folder / "plain.obj").string()), own = failure("mesh");
  CHECK(missing.exit_code == 66);
  for (const ProcessResult* result : {&damaged, &plain, &own}) CHECK(result->exit_code == 65);
  CHECK(damaged.messages.find("body.block.limit.map: " + (folder / "damaged.vdb").string() + ": is no sound OpenVDB") !=
        std::string::npos);
  CHECK(plain.messages.find("plain.obj: the mesh has no vertex colours; paint its vertices") != std::string::npos);
  CHECK(own.messages.find("body.block.limit.map: the mesh has no vertex colours") != std::string::npos);
}

TEST_CASE("umax inspect --map draws the factors from both sides, and tells them") {
  const TemporaryFolder folder;
  write_held_bar(folder);
  const std::string scene = write_scene(folder, held_bar("limit.map = \"mesh\"\n")).string(),
                    map_png = (folder / "map.png").string();
  const ProcessResult inspect = umax_program({"inspect", scene, "--map", "limit", "-o", map_png, "--json"});
  INFO(inspect.messages);
  REQUIRE(inspect.exit_code == 0);
  const auto json = nlohmann::json::parse(inspect.output);
  CHECK(json["map_picture"] == map_png);
  const auto& map = json["bodies"]["bar"]["maps"][0];
  CHECK(map["key"] == "limit.map");
  CHECK(map["factor"][0].get<double>() == Approx(0.1));
  CHECK(map["factor"][1].get<double>() == Approx(1));
  CHECK(map["hexes_outside"] == 0);
  CHECK(map["hexes_clamped"] == 0);
  CHECK(umax_program({"inspect", scene}).output.find("map        limit.map: factors of 0.1 … 1, from the paint") !=
        std::string::npos);

  // dark is at the left in front, at the right behind
  const Image8 picture = read_png8(map_png);
  const int middle = picture.height / 2, view = 640;
  const auto brightness = [&](int x) {
    const std::uint8_t* pixel = picture.pixel(x, middle);
    return int(pixel[0]) + pixel[1];  // the bar goes from blue to yellow
  };
  CHECK(brightness(view / 4) + 100 < brightness(3 * view / 4));
  CHECK(brightness(view + 4 + 3 * view / 4) + 100 < brightness(view + 4 + view / 4));

  CHECK(exit_code_of({"inspect", scene, "--map", "limit", "-o", map_png}) == 73);
  CHECK(exit_code_of({"inspect", scene, "--map", "young", "-o", map_png, "--overwrite"}) == 0);
  CHECK(exit_code_of({"inspect", scene, "--map", "colour"}) == 2);
  CHECK(exit_code_of({"inspect", scene, "-o", map_png}) == 2);
}

TEST_CASE("a run with a map goes on, is drawn and is repeated, another map file is refused") {
  const TemporaryFolder folder;
  write_held_bar(folder);
  make_file(folder / "paint.ply", file_text(folder / "bar.ply"));
  const std::string scene = write_scene(folder, held_bar("limit.map = \"paint.ply\"\n")).string(),
                    run = (folder / "run").string(), resolved = run + "/scene.toml";
  REQUIRE(exit_code_of({"simulate", scene, "-o", run, "--frames", "1-2"}) == 0);
  REQUIRE(exit_code_of({"simulate", scene, "-o", run, "--resume"}) == 0);
  REQUIRE(exit_code_of({"simulate", resolved, "-o", run + "2"}) == 0);
  CHECK(states_of(run).size() == 4);
  CHECK(states_of(run) == states_of(run + "2"));
  CHECK(exit_code_of({"render", run, "--frames", "4"}) == 0);
  CHECK(exit_code_of({"turntable", run, "--frames", "1", "-o", run + "3"}) == 0);
  // without the map it is another simulation
  CHECK(exit_code_of({"simulate", scene, "-o", run, "--resume", "--set", "body.bar.limit.map=none"}) == 65);

  make_file(folder / "paint.ply", painted_ply(painted_box({1.2, 0.1, 0.1}, [](const Vector3d&) { return 0.7; })));
  const ProcessResult other = umax_program({"simulate", resolved, "-o", run + "4"});
  CHECK(other.exit_code == 65);
  CHECK(other.messages.find("limit.map_sha256") != std::string::npos);
  CHECK(other.messages.find("is not the one that the scene was made with") != std::string::npos);
}
