#include <set>

#include "core/base/nearest_word.h"
#include "scenes/scene_keys.h"
#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

struct BadLine {
  const char* line;   // the fourth line of the scene, in [body.ball]
  const char* where;  // after "test.toml:4: "
  const char* what;   // part of what is wrong
};

}  // namespace

TEST_CASE("a bad line of a body is answered with its file, line, key and fault", "[scenes]") {
  const auto bad = GENERATE(values<BadLine>({
      {"material.poisson = 0.5", "body.ball.material.poisson", "must be > -1 and < 0.5"},
      {"material.poisson = -1", "body.ball.material.poisson", "must be > -1 and < 0.5"},
      {"material.young = \"-1 kPa\"", "body.ball.material.young", "must be > 0"},
      {"material.young = 0", "body.ball.material.young", "must be > 0"},
      {"material.young = \"500\"", "body.ball.material.young", "has no unit"},
      {"material.young = \"5 cm\"", "body.ball.material.young", "has the wrong kind of unit, cm"},
      {"material.young = true", "body.ball.material.young", "must be a number, but is true or false"},
      {"material.young = nan", "body.ball.material.young", "is not a finite number"},
      {"material.young = inf", "body.ball.material.young", "is not a finite number"},
      {"material.young = 1979-05-27", "body.ball.material.young", "must be a number, but is a date"},
      {"material.density = -500", "body.ball.material.density", "must be > 0"},
      {"material.damping_mass = -0.1", "body.ball.material.damping_mass", "must not be negative"},
      {"material.mass = \"heavy\"", "body.ball.material.mass", "must be one of \"mesh\", \"lattice\""},
      {"material.mass = 3", "body.ball.material.mass", "but is an integer"},
      {"material = 3", "body.ball.material", "is a table of keys, not a value"},
      {"material.yung = 3", "body.ball.material.yung", "unknown key"},
      {"limit.energy = \"-100 J\"", "body.ball.limit.energy", "must be positive"},
      {"limit.energy = \"100 Pa\"", "body.ball.limit.energy", "has the wrong kind of unit, Pa"},
      {"limit.density = 0", "body.ball.limit.density", "must be positive"},
      {"limit.stretch = \"-5 %\"", "body.ball.limit.stretch", "must be positive"},
      {"limit.stretch = 5", "body.ball.limit.stretch", "bare number above 1"},
      {"limit.stretch = \"2000 %\"", "body.ball.limit.stretch", "at most 1000 %"},
      {"limit.volumetric.stretch = \"-5 %\"", "body.ball.limit.volumetric.stretch", "must be positive"},
      {"limit.fibre.energy = \"3 cm\"", "body.ball.limit.fibre.energy", "has the wrong kind of unit, cm"},
      {"limit.fibre.direction = [0, 0, 0]", "body.ball.limit.fibre.direction", "is no direction"},
      {"limit.measure = \"most\"", "body.ball.limit.measure", "must be one of \"mean\", \"peak\""},
      {"limit.kind = \"strict\"", "body.ball.limit.kind", "must be one of \"none\", \"hard\", \"soft\""},
      {"cage.cells = 0", "body.ball.cage.cells", "must be 1 … 5000000"},
      {"cage.cells = 5000001", "body.ball.cage.cells", "must be 1 … 5000000"},
      {"cage.cells = [200, 200, 200]", "body.ball.cage.cells", "more than 5 million cells"},
      {"cage.cells = [3, 3]", "body.ball.cage.cells", "a number of cells or a grid of three"},
      {"cage.cells = [3, 0, 3]", "body.ball.cage.cells", "must be 1 … 5000000"},
      {"cage.cells = 2.5", "body.ball.cage.cells", "must be a whole number"},
      {"cage.cell_size = \"-10 cm\"", "body.ball.cage.cell_size", "must be > 0"},
      {"cage.cell_size = 0", "body.ball.cage.cell_size", "must be > 0"},
      {"cage.clip = \"sphere\"", "body.ball.cage.clip", "must be one of"},
      {"friction = -0.5", "body.ball.friction", "must be 0 … 1000"},
      {"position = [1, 2]", "body.ball.position", "must have 3 numbers, but has 2"},
      {"position = 1", "body.ball.position", "must be a list, but is an integer"},
      {"position = [1, 2, \"3 kg\"]", "body.ball.position", "has the wrong kind of unit, kg"},
      {"length = 3", "body.ball.length", "does not fit here"},
      {"size = [1, 1, 1]", "body.ball.size", "does not fit here"},
      {"unit = \"cm\"", "body.ball.unit", "does not fit here"},
      {"radius = \"1 parsec\"", "body.ball.radius", "has the unknown unit parsec"},
      {"height = 0", "body.ball.height", "must be > 0"},
      {"drop_height = \"-1 m\"", "body.ball.drop_height", "must be 0 … 1000000"},
      {"contact = \"bodies\"", "body.ball.contact", "must be one of \"all\", \"others\", \"obstacles\", \"none\""},
      {"contact = true", "body.ball.contact", "must be one of"},
      {"fixed = [{ min = [1, 0, 0], max = [0, 0, 0] }]", "body.ball.fixed", "has a min beyond its max"},
      {"fixed = [{ min = [1, 0, 0] }]", "body.ball.fixed", "must be a box with min and max"},
      {"fixed = { min = [1, 0, 0] }", "body.ball.fixed", "must be a list of boxes"},
      {"fixed = [{ low = [0, 0, 0], max = [1, 1, 1] }]", "body.ball.fixed", "unknown part \"low\""},
      {"look.color = \"red\"", "body.ball.look.color", "is not a colour"},
      {"look.color = [2, 0, 0]", "body.ball.look.color", "must be 0 … 1"},
      {"look.transmission = 2", "body.ball.look.transmission", "must be 0 … 1"},
      {"look.transmission_depth = 0", "body.ball.look.transmission_depth", "must be"},
      {"look.subsurface_radius = [1, 2]", "body.ball.look.subsurface_radius", "must have 3 numbers"},
      {"look.subsurface_radius = [1, 0, 2]", "body.ball.look.subsurface_radius", "must be"},
      {"mesh = \"other.obj\"", "body.ball.mesh", "only one of mesh or shape may be given"},
      {"young = 3", "body.ball.young", "unknown key"},
      {"\"\" = 3", "body.ball.", "unknown key"},
      {"a.b.c.d = 3", "body.ball.a.b.c.d", "unknown key"},
  }));
  CAPTURE(bad.line);
  const Failure failure = failure_of_text("[clip]\n[body.ball]\nshape = \"sphere\"\n" + std::string(bad.line) + "\n");
  CHECK(failure.code == 65);
  CHECK(failure.where == std::string("test.toml:4: ") + bad.where);
  CHECK(contains(failure.what, bad.what));
  CHECK_FALSE(failure.remedy.empty());
}

TEST_CASE("a bad line anywhere else is answered with its file, line, key and fault", "[scenes]") {
  const std::string ball = "[body.ball]\nshape = \"sphere\"\n";
  const auto bad = GENERATE(values<BadLine>({
      {"[clip]\nframes = 0", "test.toml:4: clip.frames", "must be 1 … 1000000"},
      {"[clip]\nfps = -60", "test.toml:4: clip.fps", "must be > 0"},
      {"[clip]\nsubsteps = 1.5", "test.toml:4: clip.substeps", "must be a whole number"},
      {"[clip]\nfps = \"60 m\"", "test.toml:4: clip.fps", "has the wrong kind of unit, m"},
      {"[solver]\nmethod = \"newton\"", "test.toml:4: solver.method", "must be one of \"exact\", \"paper\""},
      {"[solver]\ntolerance = 0", "test.toml:4: solver.tolerance", "must be"},
      {"[clop]\nframes = 3", "test.toml:3: clop", "unknown key"},
      {"clip = 3", "test.toml:3: body.ball.clip", "unknown key"},
      {"[[obstacle]]\nshape = \"plane\"", "test.toml:3: obstacle", "must be a table, but is a list"},
      {"[obstacle]\nshape = \"plane\"", "test.toml:4: obstacle.shape", "stands outside of a named table"},
      {"[obstacle.ground]\nfriction = 1", "test.toml:3: obstacle.ground.shape", "is missing"},
      {"[obstacle.ground]\nshape = \"torus\"", "test.toml:4: obstacle.ground.shape", "must be one of"},
      {"[obstacle.a]\nshape = \"mesh\"", "test.toml:3: obstacle.a.mesh", "is missing"},
      {"[obstacle.\"my plane\"]\nshape = \"plane\"", "test.toml:3: obstacle", "is no name for a obstacle"},
      {"[obstacle.\"\"]\nshape = \"plane\"", "test.toml:3: obstacle", "is no name"},
      {"[probe.tip]\nbody = \"ball\"", "test.toml:3: probe.tip.point", "is missing"},
      {"[probe.tip]\npoint = [0, 0, 0]\nbody = \"bell\"", "test.toml:5: probe.tip.body", "there is no such body"},
      {"[pair.a]\ntouch = false", "test.toml:3: pair.a.bodies", "is missing"},
      {"[pair.a]\nbodies = \"ball\"", "test.toml:4: pair.a.bodies", "must be a list of two bodies, but is a string"},
      {"[pair.a]\nbodies = [\"ball\"]", "test.toml:4: pair.a.bodies", "must have two bodies, but has 1"},
      {"[pair.a]\nbodies = [\"ball\", \"ball\", \"ball\"]", "test.toml:4: pair.a.bodies", "but has 3"},
      {"[pair.a]\nbodies = [\"ball\", 3]", "test.toml:4: pair.a.bodies", "but is an integer"},
      {"[pair.a]\nbodies = [\"ball\", \"bell\"]", "test.toml:4: pair.a.bodies", "there is no such body"},
      {"[pair.a]\nbodies = [\"ball\", \"ball\"]\nfriction = -0.1", "test.toml:5: pair.a.friction", "must be 0 … 1000"},
      {"[pair.a]\nbodies = [\"ball\", \"ball\"]\ntouch = \"no\"", "test.toml:5: pair.a.touch", "true or false"},
      {"[light.key]\nposition = [1, 1, 1]\ntarget = [1, 1, 1]", "test.toml:4: light.key.position",
       "is also the light's target"},
      {"[light.key]\nsize = 0", "test.toml:4: light.key.size", "must be > 0"},
      {"[camera]\nposition = [1, 1, 1]\ntarget = [1, 1, 1]", "test.toml:4: camera.position",
       "is also the camera's target"},
      {"[camera]\nvertical_fov = \"180 deg\"", "test.toml:4: camera.vertical_fov", "must be 0.1 … 170 deg"},
      {"[render]\nsize = [0, 720]", "test.toml:4: render.size", "must be 16 … 16384"},
      {"[render]\nsize = \"1280\"", "test.toml:4: render.size", "must be two numbers"},
      {"[render]\nsky.kind = \"map\"", "test.toml:3: render.sky.map", "is missing"},
      {"[render]\nsky.horizon = [1, 1, 1]\nsky.kind = \"constant\"", "test.toml:4: render.sky.horizon",
       "does not fit here"},
      {"[render]\nsky = { kind = \"daylight\", sun_direction = [0, 0, 0] }", "test.toml:4: render.sky.sun_direction",
       "has no direction"},
      {"[render]\nheatmap = \"stress\"", "test.toml:4: render.heatmap", "must be one of"},
      {"[render]\ndenoise = \"yes\"", "test.toml:4: render.denoise", "must be one of"},
      {"[render]\ndenoise = \"oidn\"", "test.toml:4: render.denoise", "is not in this version"},
  }));
  CAPTURE(bad.line);
  const Failure failure = failure_of_text(ball + bad.line + "\n");
  CHECK(failure.code == 65);
  CHECK(failure.where == bad.where);
  CHECK(contains(failure.what, bad.what));
  CHECK_FALSE(failure.remedy.empty());
}

TEST_CASE("an error shows the value as it was written and what to write instead", "[scenes]") {
  const Failure failure = failure_of_text("[body.ball]\nlimit.energy = \"-100 J\"\n");
  CHECK(failure.message ==
        "test.toml:2: body.ball.limit.energy: must be positive, got \"-100 J\"; give a number in J, or a quantity such "
        "as \"100 J\" (units: J, mJ, kJ, N m)");
}

TEST_CASE("text that is no TOML is answered with its line", "[scenes]") {
  CHECK(failure_of_text("[clip]\nframes = 10\nfps 60\n").where == "test.toml:3");
  CHECK(failure_of_text("[clip]\nframes = 10\nframes = 20\n").where == "test.toml:3");
  CHECK(failure_of_text("[body.a]\nlimit.energy = 100 J\n").where == "test.toml:2");
  CHECK(failure_of_text("[clip]\n[%\n").where == "test.toml:2");
  CHECK(failure_of_text("\xff\xfe\x00").code == 65);
  CHECK(failure_of_text("").what == "the scene has no body");
}

TEST_CASE("an unknown key names the nearest known one", "[scenes]") {
  const auto remedy = [](const std::string& text) { return failure_of_text(text).remedy; };
  CHECK(remedy("[body.a]\nlimit.enrgy = 1\n") == "did you mean body.a.limit.energy?");
  CHECK(remedy("[body.a]\nlimits.energy = 1\n") == "did you mean body.a.limit.energy?");
  CHECK(remedy("[body.a]\nyoung = 1\n") == "did you mean body.a.material.young?");
  CHECK(remedy("[body.a]\nfriktion = 1\n") == "did you mean body.a.friction?");
  CHECK(remedy("[render]\nsampels = 1\n") == "did you mean render.samples?");
  CHECK(remedy("[render]\nfps = 1\n") == "did you mean clip.fps?");
  CHECK(remedy("[obstacles.a]\n") == "did you mean [obstacle.NAME]?");
  CHECK(remedy("fps = 30\n") == "did you mean clip.fps?");
  CHECK(remedy("descripton = \"x\"\n") == "did you mean description?");
}

TEST_CASE("an unknown body of a pair names the nearest one, and two bodies are a pair only once", "[scenes]") {
  const std::string bodies = "[body.cat]\n[body.dog]\n";
  const Failure unknown = failure_of_text(bodies + "[pair.p]\nbodies = [\"cat\", \"dig\"]\n");
  CHECK(unknown.value == "\"dig\"");
  CHECK(unknown.remedy == "did you mean \"dog\"?");
  const std::string first = bodies + "[pair.p]\nbodies = [\"cat\", \"dog\"]\n[pair.q]\nbodies = ";
  const Failure twice = failure_of_text(first + "[\"dog\", \"cat\"]\n");
  CHECK(twice.where == "test.toml:6: pair.q.bodies");
  CHECK(twice.what == "are the bodies of [pair.p], too");
  CHECK(failure_of_text(first + "[\"dog\", \"dog\"]\n").code == 0);
}

TEST_CASE("two keys of which only one may stand are an error in a file", "[scenes]") {
  const auto fails = [](const std::string& keys) {
    const Failure failure = failure_of_text("[body.a]\n" + keys);
    return failure.code == 65 && contains(failure.what, "only one of") && failure.where.substr(0, 12) == "test.toml:3:";
  };
  CHECK(fails("limit.energy = 1\nlimit.density = 1\n"));
  CHECK(fails("limit.density = 1\nlimit.stretch = 0.1\n"));
  CHECK(fails("cage.cells = 10\ncage.cell_size = 1\n"));
  CHECK(fails("height = 1\nscale = 1\n"));
  CHECK(fails("position = [0, 0, 0]\ndrop_height = 1\n"));
}

TEST_CASE("every key with a single letter mistyped is refused or another key, never a crash", "[scenes]") {
  for (const SceneSection& section : scene_sections()) {
    std::set<std::string> known;
    for (const std::string& name : section.key_names()) known.insert(name);
    for (const SceneKey& key : section.keys)
      for (std::size_t at = 0; at < key.name.size(); ++at) {
        std::string name = key.name;
        if (name[at] == '.') continue;
        name[at] = 'q';
        const std::string thing = section.within.empty() ? "a" : "a.b";
        const std::string table = section.name.empty() ? "" : "[" + section.header(thing) + "]\n";
        const Failure failure = failure_of_text(table + name + " = 1\n");
        CAPTURE(section.name, name);
        REQUIRE(failure.code == 65);
        if (!known.count(name)) {
          REQUIRE(failure.what == "unknown key");
          const std::size_t from = std::string("did you mean ").size();
          const std::string suggestion = failure.remedy.substr(from, failure.remedy.size() - from - 1);
          // the key that was meant, or another one that is as near
          REQUIRE(edit_distance(suggestion, section.key_prefix(thing) + name) <= 1);
        }
      }
  }
}
