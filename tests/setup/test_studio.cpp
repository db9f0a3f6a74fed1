// Scenes whose files name neither lights nor a sky get those of a studio, in proportion to their bodies.
#include "tools/setup/studio.h"

#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;

namespace {

std::string block(double size, const std::string& more = {}) {
  const std::string edge = std::to_string(size), middle = std::to_string(size / 2);
  return "[body.block]\nshape = \"box\"\nsize = [" + edge + ", " + edge + ", " + edge + "]\nposition = [0, " + middle +
         ", 0]\ncage.cells = [2, 2, 2]\n[obstacle.ground]\nshape = \"plane\"\n" + more;
}

Scene lit(const std::string& text) {
  return set_up(parse_scene({.text = text}, {})).scene;
}

}  // namespace

TEST_CASE("a scene that names no light and no sky gets the studio's, as large as its bodies") {
  const Scene small = lit(block(0.1)), large = lit(block(2));
  REQUIRE(small.lights.size() == 2);
  REQUIRE(large.lights.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK((20 * small.lights[i].position.at(0) - large.lights[i].position.at(0)).norm() < 1e-9);
    CHECK(20 * small.lights[i].size.at(0) == Approx(large.lights[i].size.at(0)));
    // as bright
    CHECK(400 * small.lights[i].power.at(0) == Approx(large.lights[i].power.at(0)));
  }
  CHECK(*large.obstacles[0].fade == Approx(20 * *small.obstacles[0].fade));
  CHECK_FALSE(small.wants_lights);
}

TEST_CASE("who names a light, a sky or a backdrop keeps what the file says") {
  CHECK(lit(block(1, "[light.key]\n")).lights.size() == 1);
  CHECK(lit(block(1, "[render]\nsky.kind = \"constant\"\n")).lights.empty());
  CHECK(lit(block(1, "[render]\nsky = { kind = \"gradient\" }\n")).lights.empty());
  CHECK(lit(block(1, "[render]\nbackdrop = [1, 1, 1]\n")).lights.empty());
  CHECK(lit(block(1, "[render]\nsamples = 4\n")).lights.size() == 2);
  CHECK(*lit(block(1) + "fade = 3\n").obstacles[0].fade == 3);
}

TEST_CASE(
    "the resolved scene has the lights and stays the same when it is read, and before lighting it asks for them "
    "still") {
  const Scene scene = lit(block(0.3));
  const std::string text = resolved_toml(scene);
  const Scene again = lit(text);
  CHECK(resolved_toml(again) == text);
  REQUIRE(again.lights.size() == 2);
  // to the last bit: pictures are the same bytes
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(again.lights[i].position.at(0) == scene.lights[i].position.at(0));
    CHECK(again.lights[i].target.at(0) == scene.lights[i].target.at(0));
    CHECK(again.lights[i].size.at(0) == scene.lights[i].size.at(0));
    CHECK(again.lights[i].power.at(0) == scene.lights[i].power.at(0));
    const Vector3d difference = again.lights[i].color.at(0) - scene.lights[i].color.at(0);
    CAPTURE(difference);
    CHECK(difference.cwiseAbs().maxCoeff() == 0);
  }
  CHECK(again.obstacles[0].fade == scene.obstacles[0].fade);
  const Scene unlit = parse_scene({.text = block(0.3)}, {});
  CHECK(unlit.wants_lights);
  CHECK(parse_scene({.text = resolved_toml(unlit)}, {}).wants_lights);
  CHECK(resolved_toml(lit(resolved_toml(unlit))) == text);
}

TEST_CASE("built-in scenes have lights of their own") {
  for (const char* name : {"beam", "sphere", "collapse", "figure", "turntable", "heap"})
    CHECK_FALSE(load_scene(name, {}).wants_lights);
}
