// Scene keys of maps: limit.map and material.young_map with their grids, ranges and files.
#include "core/files/sha256.h"
#include "scenes/resolved_scene.h"
#include "tests/scenes/scene_testing.h"

using namespace umax;
using namespace umax::test;

namespace {

// the reader only looks at the files' bytes and names
std::filesystem::path map_file(const std::string& name) {
  return write_file(name, "factors");
}

std::string ball(const std::string& more) {
  return "[body.ball]\nshape = \"sphere\"\nlimit.stretch = \"10 %\"\n" + more;
}
std::string keyed(const std::string& key, const std::filesystem::path& path) {
  return key + " = \"" + path.string() + "\"\n";
}

}  // namespace

TEST_CASE("a map stands in the scene by absolute path and SHA-256, and reads back as itself", "[scenes]") {
  const auto paint = map_file("paint.ply"), grid = map_file("soft.vdb");
  const std::string text = ball(keyed("limit.map", paint) + "limit.map_range = [0.05, 4]\n" +
                                keyed("material.young_map", grid) + "material.young_map_grid = \"density\"\n");
  const Scene scene = read_text(text);
  const MapSource &limit = scene.bodies[0].limit_map, &young = scene.bodies[0].young_map;
  CHECK(limit.path == paint);
  CHECK(limit.sha256 == sha256_of_file(paint));
  CHECK(limit.range->black == 0.05);
  CHECK(limit.range->white == 4);
  CHECK_FALSE(limit.is_grid());
  CHECK(young.is_grid());
  CHECK(young.grid == "density");
  CHECK_FALSE(young.range.has_value());

  const std::string resolved = resolved_toml(scene);
  CHECK(contains(resolved, "limit.map_sha256 = \"" + limit.sha256));
  CHECK(contains(resolved, "material.young_map_grid = \"density\""));
  CHECK_FALSE(contains(resolved, "material.young_map_range"));
  CHECK(resolved_toml(read_text(resolved)) == resolved);
  // what a map of colours takes for black and white is written out
  CHECK(contains(resolved_toml(read_text(ball(keyed("limit.map", paint)))), "limit.map_range = [0.1, 1]"));
  CHECK_FALSE(contains(resolved_toml(read_text(ball(""))), "_map"));
}

TEST_CASE("the paint of the body's own mesh and no map are words", "[scenes]") {
  const Scene own = read_text(ball("limit.map = \"mesh\"\n"));
  CHECK(own.bodies[0].limit_map.own_paint);
  CHECK(own.bodies[0].limit_map.path.empty());
  CHECK(resolved_toml(read_text(resolved_toml(own))) == resolved_toml(own));
  CHECK_FALSE(read_text(ball("limit.map = \"none\"\n")).bodies[0].limit_map.is_set());
  const std::string painted = ball(keyed("limit.map", map_file("paint.ply")));
  CHECK_FALSE(read_text(painted, {"body.ball.limit.map=none"}).bodies[0].limit_map.is_set());
}

TEST_CASE("a --set reaches every part of a map, and drops what belonged to another file", "[scenes]") {
  const auto paint = map_file("paint.ply"), grid = map_file("soft.vdb");
  const std::string resolved = resolved_toml(
      read_text(ball(keyed("limit.map", grid) + "limit.map_grid = \"density\"\nlimit.map_range = [2, 3]\n")));
  const Scene scene = read_text(resolved, {"body.ball.limit.map=" + paint.string()});
  CHECK(scene.bodies[0].limit_map.path == paint);
  CHECK(scene.bodies[0].limit_map.grid.empty());
  CHECK(scene.bodies[0].limit_map.range->white == 3);
  const Scene more = read_text(resolved, {"body.ball.limit.map_grid=mask", "body.ball.limit.map_range=[0.5, 8]"});
  CHECK(more.bodies[0].limit_map.grid == "mask");
  CHECK(more.bodies[0].limit_map.range->white == 8);
}

TEST_CASE("maps that are missing or changed, and keys that do not fit, are refused", "[scenes]") {
  CHECK(failure_of_text(ball("limit.map = \"no/such.vdb\"\n")).code == 66);
  const std::string paint = keyed("limit.map", map_file("paint.ply"));
  for (const auto& [keys, part] :
       {std::pair(std::string("limit.map_grid = \"a\"\n"), "it belongs to a map from a .vdb file"),
        {"limit.map_range = [1, 2]\n", "it belongs to a map"},
        {"limit.map_sha256 = \"00\"\n", "it belongs to a map from a file"},
        {paint + "limit.map_grid = \"a\"\n", "it belongs to a map from a .vdb file"},
        {paint + "limit.map_range = [1]\n", "write [0.1, 1]"},
        {paint + "limit.map_range = [0, 1]\n", "give a number 0.01 … 1000"},
        {paint + "limit.map_range = [1, 2000]\n", "give a number 0.01 … 1000"}}) {
    const Failure failure = failure_of_text(ball(keys));
    CAPTURE(keys, failure.message);
    CHECK(failure.code == 65);
    CHECK(contains(failure.remedy, part));
  }
  const std::string resolved = resolved_toml(read_text(ball(keyed("limit.map", map_file("changing.ply")))));
  CHECK(failure_of_text(resolved).code == 0);
  write_file("changing.ply", "other factors");
  const Failure changed = failure_of_text(resolved);
  CHECK(changed.code == 65);
  CHECK(contains(changed.where, "body.ball.limit.map_sha256"));
  CHECK(contains(changed.what, "is not the one that the scene was made with"));
}
