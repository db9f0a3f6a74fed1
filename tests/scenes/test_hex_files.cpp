// Scene keys of meshes of hexes: as bodies, and as cages.
#include "core/files/sha256.h"
#include "scenes/resolved_scene.h"
#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

// the reader only looks at the files' bytes and names
std::filesystem::path hexes(const std::string& name) {
  return write_file(name, "hexes");
}

std::string ball_in(const std::filesystem::path& cage, const std::string& more = {}) {
  return "[body.ball]\nshape = \"sphere\"\ncage.mesh = \"" + cage.string() + "\"\n" + more;
}

}  // namespace

TEST_CASE("a scene with a mesh of hexes asks for no cells, and reads back as itself", "[scenes]") {
  const std::string text = "[body.bar]\nmesh = \"" + hexes("bar.msh").string() + "\"\nunit = \"cm\"\nup = \"z\"\n";
  const Scene scene = read_text(text);
  CHECK(scene.bodies[0].brings_its_hexes());
  const std::string resolved = resolved_toml(scene);
  CHECK_FALSE(contains(resolved, "cage."));
  CHECK(resolved_toml(read_text(resolved)) == resolved);
  for (const char* key : {"cage.cells = 100", "cage.cells = [2, 2, 2]", "cage.cell_size = \"1 cm\""}) {
    const Failure failure = failure_of_text(text + key + "\n");
    CAPTURE(key, failure.message);
    CHECK(failure.code == 65);
    CHECK(contains(failure.where, "test.toml:5: body.bar.cage.cell"));
    CHECK(contains(failure.what, "the hexes of bar.msh are the cage"));
  }
  const Failure cage = failure_of_text(text + "cage.mesh = \"" + hexes("other.vtk").string() + "\"\n");
  CHECK(contains(cage.what, "the hexes of bar.msh are the cage"));
  const Failure clip = failure_of_text(text + "cage.clip = \"box\"\n");
  CHECK(clip.code == 65);
  CHECK(contains(clip.remedy, "the hexes of a file are the whole cage"));
}

TEST_CASE("cage.mesh stands instead of cells, by absolute path and SHA-256", "[scenes]") {
  const auto cage = hexes("cage.vtu");
  const Scene scene = read_text(ball_in(cage));
  const auto& source = std::get<MeshSource>(scene.bodies[0].cage.size);
  CHECK(source.path == cage);
  CHECK(source.sha256 == sha256_of_file(cage));
  CHECK_FALSE(scene.bodies[0].brings_its_hexes());
  const std::string resolved = resolved_toml(scene);
  CHECK(contains(resolved, "cage.mesh_sha256 = \"" + source.sha256));
  CHECK_FALSE(contains(resolved, "cage.cells"));
  CHECK_FALSE(contains(resolved, "cage.clip"));
  CHECK(resolved_toml(read_text(resolved)) == resolved);

  for (const char* key : {"cage.cells = 100", "cage.cell_size = \"1 cm\""})
    CHECK(contains(failure_of_text(ball_in(cage, key)).what, "only one of cage.cells, cage.cell_size or cage.mesh"));
  CHECK(contains(failure_of_text(ball_in(cage, "cage.clip = \"box\"\n")).what, "does not fit here"));
  // --set replaces one by the other
  CHECK(std::get<int>(read_text(ball_in(cage), {"body.ball.cage.cells=50"}).bodies[0].cage.size) == 50);
  const std::string cells = "[body.ball]\nshape = \"sphere\"\ncage.cells = 50\ncage.clip = \"box\"\n";
  const Scene replaced = read_text(cells, {"body.ball.cage.mesh=" + cage.string()});
  CHECK(std::holds_alternative<MeshSource>(replaced.bodies[0].cage.size));
}

TEST_CASE("a cage.mesh that is missing, changed or no mesh of hexes is refused", "[scenes]") {
  CHECK(failure_of_text(ball_in("no/such.msh")).code == 66);
  const Failure surface = failure_of_text(ball_in(write_mesh("surface.obj")));
  CHECK(surface.code == 65);
  CHECK(contains(surface.what, "no mesh of hexes"));

  const std::string resolved = resolved_toml(read_text(ball_in(hexes("changing.msh"))));
  CHECK(failure_of_text(resolved).code == 0);
  write_file("changing.msh", "other hexes");
  const Failure changed = failure_of_text(resolved);
  CHECK(changed.code == 65);
  CHECK(contains(changed.where, "body.ball.cage.mesh_sha256"));
  CHECK(contains(failure_of_text("[body.ball]\nshape = \"sphere\"\ncage.mesh_sha256 = \"00\"\n").remedy, "cage.mesh"));
}
