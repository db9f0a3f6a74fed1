#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

const std::string two_bodies = R"([clip]
frames = 10
[body.beam]
shape = "cylinder"
radius = 0.06
position = [0, 1, 0]
limit.energy = "100 J"
[body.sphere]
shape = "sphere"
limit.kind = "none"
)";

Scene with(const std::vector<std::string>& sets) {
  return read_text(two_bodies, sets);
}
Failure failure_with(const std::vector<std::string>& sets) {
  return failure_of_text(two_bodies, sets);
}

}  // namespace

TEST_CASE("a --set takes quantities, words, numbers, lists and tables without quotes", "[overrides]") {
  const Scene scene = with({
      "body.beam.limit.energy=0.1J",
      "body.beam.material.young=2 MPa",
      "body.beam.material.poisson=.4",
      "body.beam.cage.cells=[14,2,2]",
      "body.beam.cage.clip=box",
      "body.beam.position=[\"10 cm\", 2, 3]",
      "body.beam.look.color=#ffffff",
      "solver.method=exact",
      "solver.energy=true",
      "clip.gravity=[0, 0, 0]",
      "render.size=640x360",
      "render.denoise=false",
      "description=a test of 5 things",
  });
  const BodyDescription& beam = scene.bodies[0];
  CHECK(beam.limit.value.at(0) == 0.1);
  CHECK(beam.material.young.at(0) == 2e6);
  CHECK(beam.material.poisson == 0.4);
  CHECK(std::get<Vector3i>(beam.cage.size) == Vector3i(14, 2, 2));
  CHECK(beam.cage.clip == CageDescription::Clip::box);
  CHECK(beam.position == Vector3d(0.1, 2, 3));
  CHECK(beam.look.base_color == Vector3f(1, 1, 1));
  CHECK(scene.solver.method == SolverMethod::exact);
  CHECK(scene.solver.energy == EnergyMeasure::true_energy);
  CHECK(scene.clip.gravity == Vector3d(0, 0, 0));
  CHECK(scene.render.width == 640);
  CHECK(scene.render.denoise == NoiseFilter::none);
  CHECK(scene.description == "a test of 5 things");
}

TEST_CASE("a limit that is set replaces the file's and turns none into hard", "[overrides]") {
  const Scene scene = with({"body.beam.limit.stretch=20%", "body.sphere.limit.density=300 J/m^3"});
  CHECK(scene.bodies[0].limit.unit == LimitUnit::stretch);
  CHECK(scene.bodies[0].limit.value.at(0) == 0.2);
  CHECK(scene.bodies[0].limit.kind == LimitKind::hard);
  CHECK(scene.bodies[1].limit.unit == LimitUnit::density);
  CHECK(scene.bodies[1].limit.kind == LimitKind::hard);
}

TEST_CASE("of several limits that are set the last one counts", "[overrides]") {
  const Scene scene = with({"body.beam.limit.energy=5", "body.beam.limit.density=300", "body.beam.limit.stretch=30%"});
  CHECK(scene.bodies[0].limit.unit == LimitUnit::stretch);
  CHECK(scene.bodies[0].limit.value.at(0) == 0.3);
}

TEST_CASE("a kind that is set stands, whatever limit is set beside it", "[overrides]") {
  CHECK(with({"body.beam.limit.kind=none"}).bodies[0].limit.kind == LimitKind::none);
  CHECK(with({"body.beam.limit.kind=none"}).bodies[0].limit.value.at(0) == 100);
  CHECK(with({"body.sphere.limit.kind=soft", "body.sphere.limit.energy=3"}).bodies[1].limit.kind == LimitKind::soft);
  CHECK(with({"body.sphere.limit.energy=3", "body.sphere.limit.kind=none"}).bodies[1].limit.kind == LimitKind::none);
}

TEST_CASE("other keys of which only one may stand replace each other, too", "[overrides]") {
  const Scene scene = with({"body.beam.drop_height=2", "body.beam.cage.cell_size=10 cm"});
  CHECK_FALSE(scene.bodies[0].position);
  CHECK(scene.bodies[0].drop_height == 2.0);
  CHECK(std::get<double>(scene.bodies[0].cage.size) == 0.1);
}

TEST_CASE("a shape or mesh that is set replaces what the file has", "[overrides]") {
  const Scene boxed = with({"body.beam.shape=box", "body.beam.size=[1,2,3]"});
  CHECK(std::get<BoxShape>(boxed.bodies[0].source).size == Vector3d(1, 2, 3));
  const Scene reversed = with({"body.beam.size=[1,2,3]", "body.beam.shape=box"});
  CHECK(std::get<BoxShape>(reversed.bodies[0].source).size == Vector3d(1, 2, 3));
  const auto mesh = write_mesh("override.obj");
  const Scene meshed = with({"body.beam.mesh=" + mesh.string()});
  CHECK(std::get<MeshSource>(meshed.bodies[0].source).path == mesh);
}

TEST_CASE("keyframes can be set", "[overrides]") {
  const Scene scene = with({"body.beam.limit.energy={keys=[[0,100],[1,\"5 J\"]], interpolation=\"smooth\"}"});
  CHECK(scene.bodies[0].limit.value.at(0.5) == Approx(52.5));
  CHECK(scene.bodies[0].limit.value.at(2) == 5);
}

TEST_CASE("a --set that is wrong names itself, its value and the nearest key", "[overrides]") {
  const Failure typo = failure_with({"body.beam.limit.enrgy=1"});
  CHECK(typo.message == "--set body.beam.limit.enrgy: unknown key; did you mean body.beam.limit.energy?");
  const Failure unit = failure_with({"body.beam.limit.energy=3 cm"});
  CHECK(unit.where == "--set body.beam.limit.energy");
  CHECK(unit.value == "3 cm");
  CHECK(unit.code == 65);
  CHECK(failure_with({"body.beam.material.poisson=0.5"}).what == "must be > -1 and < 0.5");
  CHECK(contains(failure_with({"body.beam.limit=5"}).what, "table of keys"));
  CHECK(contains(failure_with({"body=5"}).what, "table of keys"));
  CHECK(contains(failure_with({"body.beam=5"}).what, "table of keys"));
  CHECK(failure_with({"bdy.beam.radius=5"}).remedy == "did you mean [body.NAME]?");
  CHECK(failure_with({".=5"}).code == 65);
  CHECK(failure_with({"clip.frames="}).code == 65);
}

TEST_CASE("a --set of a thing that is not there names the nearest", "[overrides]") {
  const Failure failure = failure_with({"body.bean.friction=1"});
  CHECK(failure.what == "the scene has no body of this name");
  CHECK(failure.value == "bean");
  CHECK(contains(failure.remedy, "did you mean beam?"));
  // a shape would make a new body, but not when the name is nearly that of another
  CHECK(failure_with({"body.bean.shape=box"}).code == 65);
}

TEST_CASE("a --set of what makes a thing adds it", "[overrides]") {
  const Scene scene = with({"obstacle.ground.friction=1", "obstacle.ground.shape=plane", "probe.top.point=[0,1,0]",
                            "probe.top.body=beam", "light.sun.position=[0,9,0]"});
  REQUIRE(scene.obstacles.size() == 1);
  CHECK(scene.obstacles[0].friction == 1);
  REQUIRE(scene.probes.size() == 1);
  CHECK(scene.probes[0].body == "beam");
  CHECK(scene.lights.size() == 1);
}

TEST_CASE("a --set without = or key is wrong usage", "[overrides]") {
  CHECK(failure_of([] { parse_override("clip.frames"); }).code == 2);
  CHECK(failure_of([] { parse_override("=5"); }).code == 2);
  CHECK(failure_of([] { parse_override(""); }).code == 2);
  CHECK(parse_override(" clip.frames = 5 ").key == "clip.frames");
  CHECK(parse_override("a=b=c").value == "b=c");
}

TEST_CASE("a value cannot smuggle in further keys", "[overrides]") {
  const Scene scene = with({"description=\"x\"\nname = \"y\""});
  CHECK(scene.name == "scene");
}

TEST_CASE("a --set of a part's limit turns that limit on and leaves the others alone", "[overrides]") {
  const Scene scene = with({"body.beam.limit.volumetric.stretch=5%", "body.beam.limit.fibre.density=300",
                            "body.beam.limit.fibre.energy=2 J", "body.beam.limit.fibre.measure=peak",
                            "body.beam.limit.fibre.direction=[0,2,0]", "body.beam.limit.deviatoric.kind=soft"});
  const BodyDescription& beam = scene.bodies[0];
  CHECK(beam.limit.unit == LimitUnit::energy);
  CHECK(beam.limit.value.at(0) == 100);
  CHECK(beam.limit.measure == LimitMeasure::mean);
  CHECK(beam.part_limits.volumetric.kind == LimitKind::hard);
  CHECK(beam.part_limits.volumetric.unit == LimitUnit::stretch);
  CHECK(beam.part_limits.volumetric.value.at(0) == 0.05);
  CHECK(beam.part_limits.fibre.unit == LimitUnit::energy);
  CHECK(beam.part_limits.fibre.value.at(0) == 2);
  CHECK(beam.part_limits.fibre.measure == LimitMeasure::peak);
  CHECK(beam.part_limits.fibre_direction == Vector3d(0, 2, 0));
  CHECK(beam.part_limits.deviatoric.kind == LimitKind::soft);
  CHECK(with({"body.beam.limit.volumetric.stretch=5%", "body.beam.limit.volumetric.kind=none"})
            .bodies[0]
            .part_limits.volumetric.kind == LimitKind::none);
}
