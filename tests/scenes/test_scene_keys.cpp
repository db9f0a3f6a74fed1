#include "scenes/scene_keys.h"

#include <random>
#include <set>

#include "core/base/nearest_word.h"
#include "scenes/scene_key_table.h"
#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

TEST_CASE("every key is documented with type, default and meaning, and stands once", "[keys]") {
  std::set<std::string> seen;
  for (const SceneSection& section : scene_sections())
    for (const SceneKey& key : section.keys) {
      CAPTURE(section.name, key.name);
      CHECK(seen.insert(section.name + "." + key.name).second);
      CHECK_FALSE(key.type.empty());
      CHECK_FALSE(key.default_value.empty());
      CHECK(key.meaning.size() > 5);
      for (const std::string& other : key.resets) CHECK(section.find(other));
    }
  CHECK(seen.size() > 80);
}

TEST_CASE("the keys that scripts rely on are there", "[keys]") {
  const std::vector<std::pair<const char*, std::vector<const char*>>> promised = {
      {"clip", {"frames", "fps", "substeps", "gravity", "allow_overlap"}},
      {"solver", {"method", "tolerance", "energy", "rotation", "jacobian"}},
      {"body",
       {"mesh",
        "unit",
        "up",
        "shape",
        "size",
        "radius",
        "length",
        "height",
        "scale",
        "rotation",
        "position",
        "drop_height",
        "velocity",
        "spin",
        "friction",
        "contact",
        "cage.cells",
        "cage.cell_size",
        "cage.clip",
        "material.young",
        "material.poisson",
        "material.density",
        "material.mass",
        "material.damping_mass",
        "material.damping_stiffness",
        "limit.kind",
        "limit.energy",
        "limit.density",
        "limit.stretch",
        "fixed"}},
      {"obstacle", {"shape", "friction", "position", "rotation", "size", "radius", "mesh"}},
      {"pair", {"bodies", "touch", "friction"}},
      {"probe", {"body", "point"}},
      {"render", {"engine", "size", "samples", "heatmap"}},
  };
  for (const auto& [section, keys] : promised)
    for (const char* key : keys) {
      CAPTURE(section, key);
      REQUIRE(find_section(section));
      CHECK(find_section(section)->find(key));
    }
}

TEST_CASE("the page of keys and the help hold every key", "[keys]") {
  const std::string page = scene_key_page(), help = scene_key_help();
  for (const SceneSection& section : scene_sections())
    for (const SceneKey& key : section.keys) {
      CHECK(contains(page, "| `" + key.name + "` | "));
      CHECK(contains(help, key.name));
      CHECK(contains(help, key.meaning));
    }
}

TEST_CASE("defaults in the table are those of the program", "[keys]") {
  const auto default_of = [](const char* section, const char* key) {
    return find_section(section)->find(key)->default_value;
  };
  CHECK(default_of("clip", "frames") == "120");
  CHECK(default_of("clip", "gravity") == "[0, -9.81, 0]");
  CHECK(default_of("body", "material.young") == "500000");
  CHECK(default_of("body", "cage.cells") == "365");
  CHECK(default_of("body", "contact") == "\"all\"");
  CHECK(default_of("pair", "touch") == "true");
  CHECK(default_of("render", "size") == "[1280, 720]");
  CHECK(default_of("probe", "point") == "required");
}

TEST_CASE("random overrides are read or refused, never a crash", "[keys]") {
  const std::string text =
      "[body.a]\nshape = \"sphere\"\n[obstacle.a]\nshape = \"box\"\n[pair.a]\nbodies = [\"a\", "
      "\"a\"]\n[probe.a]\npoint = [0, 0, 0]\n[light.a]\n";
  const std::vector<std::string> values = {"1",
                                           "-1",
                                           "0.5",
                                           "nan",
                                           "true",
                                           "\"\"",
                                           "",
                                           "5 cm",
                                           "20 %",
                                           "[1, 2, 3]",
                                           "[[]]",
                                           "{}",
                                           "{ keys = [[0, 1]] }",
                                           "{ keys = [[0, [1, 2, 3]]] }",
                                           "1e400",
                                           "99999999999999999999",
                                           "'''",
                                           "#",
                                           "=",
                                           "none",
                                           "1979-05-27",
                                           "[",
                                           "\x01",
                                           "é",
                                           "[{ min = [0,0,0], max = [1,1,1] }]"};
  for (const SceneSection& section : scene_sections())
    for (const SceneKey& key : section.keys)
      for (const std::string& value : values) {
        const std::string name = section.key_prefix("a") + key.name;
        const Failure failure = failure_of([&] { parse_scene({.text = text}, {{name, value}}); });
        CAPTURE(name, value, failure.message);
        REQUIRE((failure.code == 0 || failure.code == 65 || failure.code == 66));
        if (failure.code != 0 && !value.empty() && failure.value == value) REQUIRE(contains(failure.where, "--set"));
      }
}

TEST_CASE("the edit distance counts insertions, deletions, substitutions and swaps", "[keys]") {
  CHECK(edit_distance("energy", "energy") == 0);
  CHECK(edit_distance("enrgy", "energy") == 1);
  CHECK(edit_distance("enregy", "energy") == 1);
  CHECK(edit_distance("", "abc") == 3);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(nearest_word("beem", {"armadillo", "beam", "figure"}) == "beam");
  CHECK(nearest_word("x", {}).empty());
}
