#include "scenes/resolved_scene.h"

#include <algorithm>
#include <random>

#include "core/files/sha256.h"
#include "scenes/builtin_scenes.h"
#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

Scene load_builtin(const std::string& name) {
  if (name != "armadillo") return load_scene(name);
  return load_scene(name, {{"body.armadillo.mesh", write_mesh("armadillo.obj").string()}});
}

}  // namespace

TEST_CASE("a resolved built-in scene reads back as itself, byte for byte", "[resolved]") {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    CAPTURE(builtin.name);
    const std::string resolved = resolved_toml(load_builtin(builtin.name));
    const auto path = write_file("resolved/scene.toml", resolved);
    const Scene again = load_scene(path.string());
    CHECK(again.name == builtin.name);
    CHECK(resolved_toml(again) == resolved);
  }
}

TEST_CASE("every key that is set survives the resolved scene", "[resolved]") {
  const auto mesh = write_mesh("survivor.obj");
  const auto picture = write_file("sky.exr", "not looked into");
  const std::string text = R"(
name = "every \"key\"\n"
description = "µ – \\ \t"
[clip]
frames = 7
fps = 29.97
[solver]
method = "exact"
energy = "paper"
rotation = "kuhn"
jacobian = "warped"
tolerance = 1e-2
[body.b]
contact = "others"
mesh = ")" + mesh.string() +
                           R"("
unit = "cm"
up = "-z"
scale = 0.1
rotation = [0.1, "1 rad", 3]
position = [1, 2, 0.30000000000000004]
velocity = ["1 km/h", 0, 0]
spin = ["1 turn/s", 0, 0]
cage.cell_size = "7 cm"
material.young = { keys = [[0, "500 kPa"], ["0.5 s", 1e6]], interpolation = "smooth" }
limit.kind = "soft"
limit.stretch = { keys = [[0, "150 %"], [1, "20 %"]] }
fixed = [{ min = [-1, -1, -1], max = [0, 1, 1] }, { min = [2, 0, 0], max = [2, 0, 0] }]
look.color = "#123456"
look.metallic = 0.3
[body.a]
shape = "box"
size = [0.1, 0.2, 0.3]
drop_height = "1 in"
limit.density = "3 kJ/m^3"
limit.measure = "peak"
limit.volumetric.stretch = { keys = [[0, "15 %"], [1, "2 %"]] }
limit.fibre.energy = "7 J"
limit.fibre.kind = "soft"
limit.fibre.direction = [0, 2, 0.30000000000000004]
[obstacle.press]
shape = "box"
size = [0.1, 0.7, 0.3]
position = { keys = [[-1, [0, 1, 0]], [1, [0, 0.1, 0]]] }
rotation = { keys = [[0, [0, 0, 0]], [1, [0, "1 turn", 0]]], interpolation = "smooth" }
[obstacle.ball]
shape = "sphere"
radius = 0.3
visible = false
[obstacle.terrain]
shape = "mesh"
mesh = ")" + mesh.string() +
                           R"("
height = 3
[pair.slippery]
bodies = ["b", "a"]
friction = 0.07
[pair.b_itself]
bodies = ["b", "b"]
touch = false
[probe.p]
body = "a"
point = [0, 0, 0]
[camera]
position = [1, 2, 3]
aperture_radius = "2 mm"
[light.key]
power = "1.1 kW"
color = "#ff8800"
[render]
engine = "osmesa"
size = [320, 180]
heatmap = "energy"
backdrop = [0.1, 0.2, 0.3]
sky = { kind = "map", map = ")" +
                           picture.string() + R"(", intensity = 0.7, rotation = "90 deg" }
)";
  const Scene scene = read_text(text);
  const std::string resolved = resolved_toml(scene);
  const Scene again = read_text(resolved);
  CHECK(resolved_toml(again) == resolved);

  REQUIRE(again.bodies.size() == 2);
  CHECK(again.bodies[0].name == "a");
  const BodyDescription &b = again.bodies[1], &b0 = scene.bodies[1];
  CHECK(again.name == "every \"key\"\n");
  CHECK(again.description == "µ – \\ \t");
  CHECK(again.clip.fps == 29.97);
  CHECK(again.solver.rotation == RotationEstimate::kuhn);
  CHECK(again.solver.jacobian == LimitJacobian::warped);
  CHECK(again.solver.energy == EnergyMeasure::paper);
  CHECK(std::get<MeshSource>(b.source).sha256 == sha256_of_file(mesh));
  CHECK(std::get<MeshSource>(b.source).unit == 0.01);
  CHECK(std::get<MeshSource>(b.source).up == "-z");
  CHECK(b.rotation_degrees == b0.rotation_degrees);
  CHECK(b.position == Vector3d(1, 2, 0.30000000000000004));
  CHECK(b.velocity[0] == 1000.0 / 3600.0);
  CHECK(b.spin_degrees[0] == 360);
  CHECK(b.material.young.interpolation == Interpolation::smooth);
  CHECK(b.material.young.at(0.2) == b0.material.young.at(0.2));
  CHECK(b.limit.kind == LimitKind::soft);
  CHECK(b.limit.value.at(0) == 1.5);
  CHECK(b.limit.value.at(1) == 0.2);
  CHECK(again.bodies[0].limit.measure == LimitMeasure::peak);
  const PartLimitOptions& parts = again.bodies[0].part_limits;
  CHECK(parts.volumetric.kind == LimitKind::hard);
  CHECK(parts.volumetric.value.at(1) == 0.02);
  CHECK(parts.deviatoric.kind == LimitKind::none);
  CHECK(parts.fibre.kind == LimitKind::soft);
  CHECK(parts.fibre.unit == LimitUnit::energy);
  CHECK(parts.fibre_direction == Vector3d(0, 2, 0.30000000000000004));
  CHECK(b.contact == ContactWith::others);
  CHECK(again.bodies[0].contact == ContactWith::all);
  REQUIRE(again.pairs.size() == 2);
  CHECK(again.pairs[0].bodies == std::array<std::string, 2>{"b", "b"});
  CHECK_FALSE(again.pairs[0].touch);
  CHECK_FALSE(again.pairs[0].friction);
  CHECK(again.pairs[1].name == "slippery");
  CHECK(again.pairs[1].bodies == std::array<std::string, 2>{"b", "a"});
  CHECK(again.pairs[1].touch);
  CHECK(again.pairs[1].friction == 0.07);
  CHECK(b.fixed.size() == 2);
  CHECK(b.look.base_color == b0.look.base_color);
  CHECK(again.obstacles[0].name == "ball");
  CHECK(std::get<Block>(again.obstacles[1].shape).half_size == std::get<Block>(scene.obstacles[1].shape).half_size);
  CHECK(again.obstacles[1].position.at(0)[1] == Approx(0.55));
  CHECK(again.obstacles[2].height == 3.0);
  CHECK(again.lights[0].power.at(0) == 1100);
  CHECK(again.render.sky_path == picture);
  CHECK(std::get<EnvironmentMap>(again.render.sky).rotation_degrees == 90);
}

TEST_CASE("a mesh that has changed is refused by the resolved scene", "[resolved]") {
  const auto mesh = write_mesh("changing.obj");
  const std::string resolved = resolved_toml(read_text("[body.a]\nmesh = \"" + mesh.string() + "\"\n"));
  CHECK(read_text(resolved).bodies.size() == 1);
  write_file("changing.obj", "v 0 0 0\n");
  const Failure failure = failure_of_text(resolved);
  CHECK(failure.code == 65);
  CHECK(contains(failure.where, "body.a.mesh_sha256"));
  CHECK(contains(failure.what, "is not the one that the scene was made with"));
  // another mesh by --set is another matter
  CHECK(read_text(resolved, {"body.a.mesh=" + mesh.string()}).bodies.size() == 1);
}

TEST_CASE("random numbers survive the resolved scene to the last bit", "[resolved]") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-9, 9), mantissa(-1, 1);
  for (int i = 0; i < 300; ++i) {
    Scene scene = read_text("[body.a]\nshape = \"box\"\n[light.a]\n");
    const auto number = [&] { return mantissa(random) * std::pow(10.0, std::min(5.0, exponent(random))); };
    BodyDescription& body = scene.bodies[0];
    body.position = Vector3d(number(), number(), number());
    std::get<BoxShape>(body.source).size = Vector3d(number(), number(), number()).cwiseAbs();
    body.material.young = Track<double>(std::abs(number()));
    body.limit = {LimitKind::hard, LimitUnit::stretch, Track<double>(std::abs(mantissa(random)) * 3)};
    body.look.base_color = Vector3f::Random().cwiseAbs();
    const Scene again = read_text(resolved_toml(scene));
    REQUIRE(again.bodies[0].position == body.position);
    REQUIRE(std::get<BoxShape>(again.bodies[0].source).size == std::get<BoxShape>(body.source).size);
    REQUIRE(again.bodies[0].material.young.at(0) == body.material.young.at(0));
    REQUIRE(again.bodies[0].limit.value.at(0) == body.limit.value.at(0));
    REQUIRE(again.bodies[0].look.base_color == body.look.base_color);
  }
}

TEST_CASE("comments stand behind their keys and change nothing that is read", "[resolved]") {
  const Scene scene = read_text("[body.a]\nlimit.stretch = \"5 %\"\n[body.b]\nlimit.stretch = \"5 %\"\n");
  const std::string plain = resolved_toml(scene),
                    told = resolved_toml(scene, {{"body.b.limit.stretch", "= 5 J per hex"}});
  CHECK(told.find("limit.stretch = 0.05  # = 5 J per hex\n") > told.find("[body.b]"));
  CHECK(resolved_toml(read_text(told)) == plain);
}

TEST_CASE("the settings that a scene changes are those that are not the defaults", "[resolved]") {
  const Scene scene = read_text("[clip]\nfps = 60\nframes = 7\n[body.a]\nlimit.stretch = \"5 %\"\nfriction = 0.25\n");
  const std::vector<std::string> settings = changed_settings(scene);
  const auto has = [&](const std::string& setting) {
    return std::find(settings.begin(), settings.end(), setting) != settings.end();
  };
  CHECK(has("clip.frames = 7"));
  CHECK(has("body.a.friction = 0.25"));
  CHECK(has("body.a.limit.stretch = 0.05"));
  CHECK(has("body.a.limit.kind = \"hard\""));
  for (const std::string& setting : settings) {
    CHECK(setting.find("clip.fps") == std::string::npos);
    CHECK(setting.find("limit.fibre.kind") == std::string::npos);
  }
}
