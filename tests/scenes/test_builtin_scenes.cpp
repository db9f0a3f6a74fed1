#include "scenes/builtin_scenes.h"

#include <algorithm>
#include <random>

#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

TEST_CASE("the built-in scenes are those of the manual, sorted, each with one line about it", "[builtin]") {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) {
    names.push_back(scene.name);
    CHECK(scene.description.size() > 20);
    CHECK(scene.description.size() < 100);
    CHECK_FALSE(contains(scene.description, "\n"));
  }
  CHECK(std::is_sorted(names.begin(), names.end()));
  for (const char* name :
       {"armadillo", "beam", "bowl", "chain", "collapse", "figure", "heap", "hug", "sphere", "squeeze", "turntable"})
    CHECK(std::count(names.begin(), names.end(), name) == 1);
}

TEST_CASE("the beam is the paper's", "[builtin]") {
  const Scene scene = load_scene("beam");
  REQUIRE(scene.bodies.size() == 1);
  const BodyDescription& beam = scene.bodies[0];
  CHECK(scene.name == "beam");
  CHECK(scene.clip.time_step() == Approx(0.01));
  CHECK(beam.name == "beam");
  CHECK(std::get<CylinderShape>(beam.source).radius == 0.06);
  CHECK(std::get<CylinderShape>(beam.source).length == 1);
  CHECK(beam.position == Vector3d(0.5, 0, 0));
  CHECK(std::get<Vector3i>(beam.cage.size) == Vector3i(14, 2, 2));
  CHECK(beam.cage.clip == CageDescription::Clip::box);
  CHECK(beam.material.mass == MassModel::lattice);
  CHECK(beam.material.young.at(0) == 150e3);
  CHECK(beam.material.density == 500);
  CHECK(beam.material.poisson == 0.3);
  CHECK(beam.limit.kind == LimitKind::hard);
  CHECK(beam.limit.unit == LimitUnit::energy);
  CHECK(beam.limit.value.at(0) == 0.1);
  CHECK(beam.contact == ContactWith::obstacles);
  REQUIRE(beam.fixed.size() == 1);
  CHECK(beam.fixed[0].max[0] > 0);
  CHECK(beam.fixed[0].max[0] < 1.0 / 14);
  REQUIRE(scene.probes.size() == 1);
  CHECK(scene.probes[0].name == "tip");
  CHECK(scene.probes[0].point == Vector3d(1, 0, 0));
}

TEST_CASE("the spheres are the paper's", "[builtin]") {
  for (const char* name : {"sphere", "collapse"}) {
    const Scene scene = load_scene(name);
    const BodyDescription& sphere = scene.bodies.at(0);
    CHECK(sphere.name == "sphere");
    CHECK(scene.clip.time_step() == Approx(0.01));
    CHECK(std::get<SphereShape>(sphere.source).radius == 1);
    CHECK(sphere.position == Vector3d(0, 2, 0));
    CHECK(sphere.friction == 0.5);
    CHECK(sphere.contact == ContactWith::obstacles);
    CHECK(sphere.material.mass == MassModel::lattice);
    CHECK(sphere.limit.kind == LimitKind::hard);
    CHECK(std::holds_alternative<HalfSpace>(scene.obstacles.at(0).shape));
  }
  CHECK(std::get<Vector3i>(load_scene("sphere").bodies[0].cage.size).prod() == 27);
  CHECK(load_scene("sphere").bodies[0].limit.value.at(0) == 500);
  CHECK(load_scene("sphere").bodies[0].material.young.at(0) == 150e3);
  CHECK(load_scene("collapse").bodies[0].limit.value.at(0) == 50);
  CHECK(load_scene("collapse").bodies[0].material.young.at(0) == 50e3);
}

TEST_CASE("the armadillo has the manual's values and needs its mesh", "[builtin]") {
  const Failure missing = failure_of([] { load_scene("armadillo"); });
  CHECK(missing.code == 66);
  CHECK(contains(missing.message, "body.armadillo.mesh"));
  CHECK(contains(missing.message, "Stanford 3D Scanning Repository"));
  const Failure wrong = failure_of([] { load_scene("armadillo", {{"body.armadillo.mesh", "no/such.obj"}}); });
  CHECK(wrong.code == 66);
  CHECK(contains(wrong.message, "no/such.obj"));
  CHECK(contains(wrong.message, "Stanford 3D Scanning Repository"));

  const auto mesh = write_mesh("given.obj");
  const Scene scene = load_scene("armadillo", {{"body.armadillo.mesh", mesh.string()}});
  const BodyDescription& body = scene.bodies.at(0);
  CHECK(body.name == "armadillo");
  CHECK(body.height == 2.0);
  CHECK(body.drop_height == 1.0);
  CHECK(std::get<int>(body.cage.size) == 365);
  CHECK(body.material.young.at(0) == 500e3);
  CHECK(body.material.density == 500);
  CHECK(body.friction == 0.5);
  CHECK(body.contact == ContactWith::obstacles);
  CHECK(body.limit.kind == LimitKind::hard);
  CHECK(body.limit.unit == LimitUnit::energy);
  CHECK(body.limit.value.at(0) == 100);
}

TEST_CASE("the demo limits the figure's energy by a stretch of 20 % for at least 120 frames", "[builtin]") {
  const Scene scene = load_scene("figure");
  const BodyDescription& body = scene.bodies.at(0);
  CHECK(body.name == "figure");
  CHECK(std::holds_alternative<FigureShape>(body.source));
  CHECK(body.limit.kind == LimitKind::hard);
  CHECK(body.limit.unit == LimitUnit::stretch);
  CHECK(body.limit.value.at(0) == 0.2);
  CHECK(scene.clip.frames >= 120);
  CHECK(scene.render.width == 640);
  CHECK(scene.render.height == 360);
}

TEST_CASE("an unknown scene names the nearest built-in", "[builtin]") {
  const Failure failure = failure_of([] { load_scene("figur"); });
  CHECK(failure.code == 66);
  CHECK(contains(failure.remedy, "did you mean figure?"));
}

TEST_CASE("a damaged scene is read or refused, never a crash", "[builtin]") {
  std::mt19937 random(11);
  const std::vector<BuiltinScene> scenes = builtin_scenes();
  const std::string letters = "abz019.-_=[]{}\"', \n#%\xff\x01";
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text(scenes[random() % scenes.size()].text);
    for (unsigned change = 0; change <= random() % 3; ++change) {
      const std::size_t at = random() % text.size();
      const char letter = letters[random() % letters.size()];
      if (random() % 3 == 0)
        text.erase(at, 1 + random() % 8);
      else if (random() % 2 == 0)
        text.insert(at, 1, letter);
      else
        text[at] = letter;
    }
    const Failure failure = failure_of_text(text);
    if (failure.code == 0) continue;
    ++refused;
    INFO(failure.message);
    REQUIRE((failure.code == 65 || failure.code == 66));
    REQUIRE(failure.message.substr(0, 9) == "test.toml");
  }
  CHECK(refused > 1000);
}
