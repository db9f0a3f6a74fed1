#include "scenes/scene_file.h"

#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

// The current folder, changed and put back.
class InFolder {
 public:
  explicit InFolder(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::create_directories(folder);
    std::filesystem::current_path(folder);
  }
  ~InFolder() { std::filesystem::current_path(before_); }
  InFolder(const InFolder&) = delete;
  InFolder& operator=(const InFolder&) = delete;

 private:
  std::filesystem::path before_;
};

}  // namespace

TEST_CASE("paths in a scene file start at the file, those of --set at the current folder", "[scenes]") {
  const auto near_file = write_mesh("paths/project/meshes/a.obj");
  const auto near_shell = write_mesh("paths/elsewhere/a.obj");
  const auto file = write_file("paths/project/scene.toml", "[body.a]\nmesh = \"meshes/a.obj\"\n");
  const InFolder elsewhere(near_shell.parent_path());
  const auto mesh_of = [](const Scene& scene) { return std::get<MeshSource>(scene.bodies.at(0).source).path; };
  CHECK(mesh_of(load_scene("../project/scene.toml")) == near_file);
  CHECK(mesh_of(load_scene(file.string(), {{"body.a.mesh", "a.obj"}})) == near_shell);
  CHECK(load_scene("../project/scene.toml").name == "scene");
}

TEST_CASE("a missing file is not found, under the name that the user gave", "[scenes]") {
  const Failure scene = failure_of([] { load_scene("no/such.toml"); });
  CHECK(scene.code == 66);
  CHECK(scene.where == "no/such.toml");
  CHECK(failure_of([] { load_scene("missing.toml"); }).code == 66);
  CHECK(failure_of([] { load_scene("/"); }).code == 65);
  const auto file = write_file("dangling.toml", "[body.a]\nmesh = \"gone.obj\"\n");
  const Failure mesh = failure_of([&] { load_scene(file.string()); });
  CHECK(mesh.code == 66);
  CHECK(mesh.where == file.string() + ":2: body.a.mesh");
  CHECK(contains(mesh.value, "gone.obj"));
}

TEST_CASE("things come in the order of their names, whatever the file's", "[scenes]") {
  const std::string a = "[body.a]\n", b = "[body.b]\nfriction = 0.1\n";
  const Scene first = read_text(a + b), second = read_text(b + a);
  REQUIRE(first.bodies.size() == 2);
  for (int i = 0; i < 2; ++i) {
    CHECK(first.bodies[i].name == second.bodies[i].name);
    CHECK(first.bodies[i].friction == second.bodies[i].friction);
  }
}

TEST_CASE("a limit without a kind is hard, no limit is none", "[scenes]") {
  CHECK(read_text("[body.a]\n").bodies[0].limit.kind == LimitKind::none);
  CHECK(read_text("[body.a]\nlimit.energy = 3\n").bodies[0].limit.kind == LimitKind::hard);
  CHECK(read_text("[body.a]\nlimit.kind = \"soft\"\nlimit.energy = 3\n").bodies[0].limit.kind == LimitKind::soft);
  CHECK(read_text("[body.a]\nlimit.kind = \"none\"\nlimit.energy = 3\n").bodies[0].limit.kind == LimitKind::none);
}

TEST_CASE("a probe rides on the only body unless it says otherwise", "[scenes]") {
  CHECK(read_text("[body.a]\n[probe.p]\npoint = [0, 0, 0]\n").probes[0].body == "a");
  CHECK(contains(failure_of_text("[body.a]\n[body.b]\n[probe.p]\npoint = [0, 0, 0]\n").remedy, "a and b"));
}

TEST_CASE("keyframes are interpolated, in the unit of their key", "[scenes]") {
  const Scene scene = read_text(R"([body.a]
material.young = { keys = [[0, "100 kPa"], [2, 3e5]] }
limit.stretch = { keys = [["500 ms", "40 %"], [1, 0.2]], interpolation = "smooth" }
[obstacle.o]
shape = "box"
position = { keys = [[0, [0, 0, 0]], [1, ["10 cm", 1, 0]]], interpolation = "linear" }
rotation = [0, "0.5 turn", 0]
)");
  const BodyDescription& body = scene.bodies[0];
  CHECK(body.material.young.at(1) == Approx(200e3));
  CHECK(body.limit.value.at(0) == 0.4);
  CHECK(body.limit.value.at(0.75) == Approx(0.3));
  CHECK(body.limit.value.at(0.625) > 0.35);
  CHECK(scene.obstacles[0].position.at(0.5)[0] == Approx(0.05));
  CHECK(scene.obstacles[0].rotation_degrees.at(7)[1] == 180);
}

TEST_CASE("bad keyframes are refused", "[scenes]") {
  const auto what = [](const std::string& track) {
    const Failure failure = failure_of_text("[body.a]\nmaterial.young = " + track + "\n");
    CHECK(failure.code == 65);
    CHECK(failure.where == "test.toml:2: body.a.material.young");
    return failure.what;
  };
  CHECK(what("{ keys = [] }") == "has no keys");
  CHECK(what("{ }") == "has no keys");
  CHECK(contains(what("{ keys = [[0, 1], [0, 2]] }"), "not later"));
  CHECK(contains(what("{ keys = [[1, 1], [0, 2]] }"), "not later"));
  CHECK(contains(what("{ keys = [[0, -1]] }"), "must be > 0"));
  CHECK(contains(what("{ keys = [[0]] }"), "must have 2 numbers"));
  CHECK(contains(what("{ keys = 3 }"), "must be a list"));
  CHECK(contains(what("{ keys = [[0, 1]], interpolation = \"cubic\" }"), "must be one of"));
  CHECK(contains(what("{ keys = [[0, 1]], loop = true }"), "unknown part"));
  CHECK(contains(what("{ keys = [[\"1 m\", 1]] }"), "wrong kind of unit"));
}
