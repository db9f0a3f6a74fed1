// Materials by name: what a body that names one becomes, and how files of materials fail.
#include "scenes/presets.h"

#include <algorithm>

#include "scenes/resolved_scene.h"
#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

std::string body_with(const std::string& keys) {
  return "[body.toy]\nshape = \"figure\"\n" + keys;
}

BodyDescription toy(const std::string& keys, const std::vector<std::string>& sets = {}) {
  return read_text(body_with(keys), sets).bodies.at(0);
}

Failure failure_of_presets(const std::string& name, const std::string& text) {
  const auto file = write_file(name, text);
  return failure_of([&] { presets(file); });
}

}  // namespace

TEST_CASE("every built-in preset says what it is and where it comes from, and has a whole material", "[presets]") {
  const std::vector<Preset> all = presets();
  for (const char* name : {"rubber", "sponge", "gel", "fat_tissue", "muscle", "wood", "plush_toy"})
    CHECK(std::any_of(all.begin(), all.end(), [&](const Preset& preset) { return preset.name == name; }));
  for (const Preset& preset : all) {
    CAPTURE(preset.name);
    CHECK(preset.description.size() > 10);
    CHECK(preset.source.size() > 60);
    const BodyDescription body = toy("material.preset = \"" + preset.name + "\"\n");
    const BodyDescription plain = toy("");
    CHECK(body.material.young.at(0) != plain.material.young.at(0));
    CHECK(body.material.poisson < 0.5);
    CHECK(body.material.damping_stiffness.at(0) > 0);
    CHECK(body.limit.kind == LimitKind::hard);
    CHECK(body.limit.unit == LimitUnit::stretch);
    // the lines that `umax presets NAME` prints are the preset
    CHECK(resolved_toml(read_text(body_with(preset_toml(preset)))) ==
          resolved_toml(read_text(body_with("material.preset = \"" + preset.name + "\"\n"))));
  }
}

TEST_CASE("a body's own keys win over its preset, wherever they stand", "[presets]") {
  const BodyDescription body =
      toy("material.young = \"1 MPa\"\nlimit.density = 300\nmaterial.preset = \"gel\"\nmaterial.poisson = 0.3\n");
  CHECK(body.material.young.at(0) == 1e6);
  CHECK(body.material.poisson == 0.3);
  CHECK(body.material.density == 1050);
  CHECK(body.limit.unit == LimitUnit::density);  // one of a group stands for all
  CHECK(body.limit.value.at(0) == 300);
  CHECK(toy("material.preset = \"gel\"\nlimit.kind = \"none\"\n").limit.kind == LimitKind::none);
}

TEST_CASE("a preset that is set on the command line replaces the file's material and limit, not other settings",
          "[presets]") {
  const std::string keys =
      "material.young = 1\nmaterial.density = 7\nlimit.kind = \"none\"\nmaterial.mass = \"lattice\"\n";
  const BodyDescription body = toy(keys, {"body.toy.material.preset=gel"});
  CHECK(body.material.young.at(0) == 8e3);
  CHECK(body.material.density == 1050);
  CHECK(body.material.mass == MassModel::lattice);
  CHECK(body.limit.kind == LimitKind::hard);
  CHECK(body.limit.value.at(0) == 0.4);
  const std::vector<std::string> both{"body.toy.limit.stretch=5%", "body.toy.material.preset=gel"};
  CHECK(toy(keys, both).limit.value.at(0) == 0.05);
}

TEST_CASE("the resolved scene has a preset's values and needs no preset any more", "[presets]") {
  const std::string text = resolved_toml(read_text(body_with("material.preset = \"muscle\"\n")));
  CHECK_FALSE(contains(text, "preset"));
  CHECK(contains(text, "material.young = 10000\n"));
  CHECK(resolved_toml(read_text(text)) == text);
}

TEST_CASE("a file of one's own adds materials and replaces ours", "[presets]") {
  const auto file = write_file("mine.toml",
                               "[slime]\ndescription = \"green\"\nmaterial.young = \"1 kPa\"\n"
                               "[rubber]\nmaterial.young = \"9 kPa\"\n");
  const std::string set = "presets=" + file.string();
  CHECK(toy("material.preset = \"slime\"\n", {set}).material.young.at(0) == 1e3);
  CHECK(toy("material.preset = \"slime\"\n", {set}).limit.kind == LimitKind::none);
  CHECK(toy("material.preset = \"rubber\"\n", {set}).material.young.at(0) == 9e3);
  CHECK(toy("material.preset = \"gel\"\n", {set}).material.young.at(0) == 8e3);
  const Scene named = read_text("presets = \"" + file.string() + "\"\n" + body_with("material.preset = \"slime\"\n"));
  CHECK(named.bodies.at(0).material.young.at(0) == 1e3);
}

TEST_CASE("an unknown preset is refused where it stands, with the nearest", "[presets]") {
  const Failure in_file = failure_of_text(body_with("material.preset = \"ruber\"\n"));
  CHECK(in_file.code == 65);
  CHECK(in_file.where == "test.toml:3: body.toy.material.preset");
  CHECK(contains(in_file.remedy, "did you mean \"rubber\"?"));
  CHECK(failure_of_text(body_with(""), {"body.toy.material.preset=gal"}).where == "--set body.toy.material.preset");
  CHECK(failure_of_text(body_with("material.preset = 5\n")).code == 65);
}

TEST_CASE("a bad file of materials is refused with its line", "[presets]") {
  CHECK(contains(failure_of_presets("p1.toml", "[a]\nmaterial.yuong = 5\n").where, "p1.toml:2: body.a.material.yuong"));
  CHECK(contains(failure_of_presets("p2.toml", "[a]\nmaterial.young = \"5 kg\"\n").where, "p2.toml:2"));
  CHECK(failure_of_presets("p3.toml", "[a]\nheight = 5\n").what == "is no key of a material");
  CHECK(failure_of_presets("p4.toml", "[a]\nmaterial.preset = \"gel\"\n").what == "is no key of a material");
  CHECK(failure_of_presets("p5.toml", "a = 5\n").code == 65);
  CHECK(failure_of_presets("p6.toml", "[a]\nlimit.energy = 1\nlimit.stretch = 0.1\n").code == 65);
  CHECK(failure_of([] { presets("no/such/file.toml"); }).code == 66);
  CHECK(failure_of_text(body_with(""), {"presets=no/such/file.toml"}).code == 66);
}

TEST_CASE("gel, silicone and fat say how light gets into them, and --set of another material takes that along",
          "[presets]") {
  CHECK(toy("material.preset = \"gel\"\n").look.transmission > 0.5f);
  CHECK(toy("material.preset = \"silicone\"\n").look.subsurface == 1);
  const BodyDescription fat = toy("material.preset = \"fat_tissue\"\n");
  CHECK(fat.look.subsurface == 1);
  CHECK(fat.look.subsurface_radius.x() > fat.look.subsurface_radius.z());
  // colour and gloss are the body's own
  CHECK(fat.look.base_color == Look().base_color);
  CHECK(toy("material.preset = \"gel\"\nlook.transmission = 0\n").look.transmission == 0);
  const BodyDescription changed =
      toy("look.transmission = 1\nlook.color = [1, 0, 0]\n", {"body.toy.material.preset=rubber"});
  CHECK(changed.look.transmission == 0);
  CHECK(changed.look.base_color == Vector3f(1, 0, 0));
}
