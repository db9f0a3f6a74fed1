// Files for other programs, without a scene: what stands in them, and that meshes come back as they went out.
#include <cstdlib>
#include <cstring>
#include <numeric>

#include "core/files/read_file.h"
#include "embedding/caches/alembic_file.h"
#include "embedding/caches/corner_values.h"
#include "embedding/caches/mesh_sequence.h"
#include "embedding/caches/obj_file.h"
#include "embedding/caches/point_cache.h"
#include "embedding/caches/usda_file.h"
#include "embedding/mesh_files/mesh_io.h"
#include "tests/embedding/alembic_text.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/temporary_folder.h"

using namespace umax;

namespace {

/// A tetrahedron with paint, and texture coordinates that differ from corner to corner of a vertex.
MovingSurface tetrahedron() {
  MovingSurface surface;
  surface.name = "tetrahedron";
  surface.library = "tetrahedron.mtl";
  surface.materials[0].name = "tetrahedron";
  surface.rest.resize(4, 3);
  surface.rest << 0, 0, 0, 1.25f, 0, 0, 0, 1.1f, 0, 0, 0, 0.3f;
  surface.triangles.resize(4, 3);
  surface.triangles << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
  surface.texture_coordinates.resize(12, 2);
  for (int corner = 0; corner < 12; ++corner)
    surface.texture_coordinates.row(corner) << float(corner % 5) / 8, float(corner % 3) / 4;
  surface.colors.resize(4, 3);
  surface.colors << 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.5f, 0.25f, 0.125f;
  return surface;
}

SurfaceFrame moved(const MovingSurface& surface, int frame) {
  SurfaceFrame out;
  out.frame = frame;
  out.time = (frame - 1) / 30.0;
  out.positions = surface.rest.rowwise() + Eigen::RowVector3f(0.1f * float(frame), 0, -2);
  out.velocities = surface.rest;
  out.normals = (surface.rest.rowwise() + Eigen::RowVector3f(1, 1, 1)).rowwise().normalized();
  return out;
}

template <class T>
T value_at(const std::string& bytes, std::size_t offset) {
  T value{};
  REQUIRE(offset + sizeof value <= bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// Four bytes the other way round.
template <class T>
T big_endian_at(const std::string& bytes, std::size_t offset) {
  std::string word = bytes.substr(offset, 4);
  std::reverse(word.begin(), word.end());
  return value_at<T>(word, 0);
}

std::string cache_of(PointCacheKind kind, const ClipSpace& clip) {
  const TemporaryFolder folder;
  const MovingSurface surface = tetrahedron();
  PointCacheWriter writer(folder / "cache", kind, 4, clip);
  for (const int frame : clip.frames) writer.append(moved(surface, frame));
  CHECK(!std::filesystem::exists(folder / "cache"));
  writer.finish();
  return read_file(folder / "cache");
}

}  // namespace

TEST_CASE("values of corners are kept once each, and found again", "[caches]") {
  const MovingSurface surface = tetrahedron();
  const CornerValues texture = distinct_values(surface.texture_coordinates);
  CHECK(texture.values.size() == 12);
  TextureCoordinates twice(6, 2);
  twice << 0, 1, 0, 1, 0.5f, 1, 0, 1, 0.5f, 1, 1, 1;
  CHECK(distinct_values(twice).index == std::vector<int>{0, 0, 1, 0, 1, 2});
  CHECK(distinct_values(TextureCoordinates()).values.empty());
}

TEST_CASE("split vertices: the surface's own come first and in their order, each corner has its own value",
          "[caches]") {
  const MovingSurface surface = tetrahedron();
  const SplitVertices split = split_vertices(4, surface.triangles, surface.texture_coordinates);
  REQUIRE(split.source.size() == 12);
  for (int v = 0; v < 4; ++v) CHECK(split.source[v] == v);
  for (int corner = 0; corner < 12; ++corner) {
    const int vertex = split.triangles(corner / 3, corner % 3);
    CHECK(split.source[vertex] == surface.triangles(corner / 3, corner % 3));
    CHECK(split.coordinates[vertex] == surface.texture_coordinates.row(corner));
  }
  // one value a vertex: no copies
  TextureCoordinates smooth(12, 2);
  for (int corner = 0; corner < 12; ++corner)
    smooth.row(corner) << float(surface.triangles(corner / 3, corner % 3)), 0.5f;
  const SplitVertices whole = split_vertices(4, surface.triangles, smooth);
  CHECK(whole.source.size() == 4);
  CHECK(whole.triangles == surface.triangles);
  CHECK(split_vertices(4, surface.triangles, {}).coordinates.empty());
}

TEST_CASE("meshes come back as they went out: vertices and triangles in order, texture, paint", "[caches]") {
  const TemporaryFolder folder;
  const MovingSurface surface = tetrahedron();
  for (const MeshFileKind kind : {MeshFileKind::obj, MeshFileKind::ply}) {
    const SurfaceFrame frame = moved(surface, 12);
    const auto path = sequence_file(folder.path(), 12, kind == MeshFileKind::obj ? "obj" : "ply");
    CHECK(path.stem() == "0012");
    MeshSequenceWriter(folder.path(), kind, surface).append(frame);
    const TriangleMesh mesh = load_mesh(path).mesh;
    CHECK(mesh.positions.cast<float>() == frame.positions);
    CHECK(mesh.triangles == surface.triangles);
    REQUIRE(mesh.colors.rows() == 4);
    CHECK((mesh.colors.cast<float>() - surface.colors).cwiseAbs().maxCoeff() <
          (kind == MeshFileKind::obj ? 1e-5f : 4e-3f));  // PLY: bytes
    if (kind == MeshFileKind::obj) CHECK(mesh.texture_coordinates == surface.texture_coordinates);
  }
  CHECK(sequence_file("f", 12345, "obj") == "f/12345.obj");
}

TEST_CASE("a surface without texture and paint says nothing of them", "[caches]") {
  MovingSurface plain = tetrahedron();
  plain.texture_coordinates.resize(0, 2);
  plain.colors.resize(0, 3);
  const std::string text = obj_text(plain, plain.rest);
  CHECK(text.find("vt ") == text.npos);
  CHECK(test::contains(text, "v 1.25 0 0\n"));
  CHECK(test::contains(text, "\nf 1 3 2\n"));
  plain.materials[0].texture = "skin.png";
  CHECK(test::contains(mtl_text(plain), "newmtl tetrahedron\n"));
  CHECK(test::contains(mtl_text(plain), "map_Kd skin.png\n"));
}

TEST_CASE("PC2 is little-endian with its sampling in seconds, MDD big-endian with times", "[caches]") {
  const ClipSpace clip{.fps = 30, .frames = {4, 6, 8}};
  const std::string pc2 = cache_of(PointCacheKind::pc2, clip), mdd = cache_of(PointCacheKind::mdd, clip);
  CHECK(pc2.substr(0, 12) == std::string("POINTCACHE2\0", 12));
  CHECK(value_at<int>(pc2, 12) == 1);
  CHECK(value_at<int>(pc2, 16) == 4);
  CHECK(value_at<float>(pc2, 20) == 0.1f);
  CHECK(value_at<float>(pc2, 24) == float(2 / 30.0));
  CHECK(value_at<int>(pc2, 28) == 3);
  REQUIRE(pc2.size() == 32 + 3 * 4 * 12);

  CHECK(big_endian_at<int>(mdd, 0) == 3);
  CHECK(big_endian_at<int>(mdd, 4) == 4);
  for (int i = 0; i < 3; ++i) CHECK(big_endian_at<float>(mdd, 8 + 4 * i) == float((3 + 2 * i) / 30.0));
  REQUIRE(mdd.size() == 20 + 3 * 4 * 12);

  const MovingSurface surface = tetrahedron();
  for (int i = 0; i < 3; ++i) {
    const SurfaceFrame frame = moved(surface, clip.frames[i]);
    for (int k = 0; k < 12; ++k) {
      CHECK(value_at<float>(pc2, 32 + 4 * (12 * i + k)) == frame.positions(k / 3, k % 3));
      CHECK(big_endian_at<float>(mdd, 20 + 4 * (12 * i + k)) == frame.positions(k / 3, k % 3));
    }
  }
}

TEST_CASE("PC2 refuses frames at unequal distances, MDD takes any", "[caches]") {
  CHECK(is_evenly_spaced({7}));
  CHECK(is_evenly_spaced({1, 9}));
  CHECK(is_evenly_spaced({1, 4, 7, 10}));
  CHECK(!is_evenly_spaced({1, 2, 4}));
  const ClipSpace uneven{.fps = 30, .frames = {1, 2, 4}};
  const test::Failure failure = test::failure_of([&] { cache_of(PointCacheKind::pc2, uneven); });
  CHECK(failure.code == 65);
  CHECK(test::contains(failure.message, "mdd"));
  CHECK(cache_of(PointCacheKind::mdd, uneven).size() == 8 + 3 * (4 + 4 * 12));
}

TEST_CASE("a cache that is not finished leaves nothing behind", "[caches]") {
  const TemporaryFolder folder;
  {
    PointCacheWriter writer(folder / "cache", PointCacheKind::pc2, 4, {.fps = 30, .frames = {1, 2}});
    writer.append(moved(tetrahedron(), 1));
  }
  CHECK(std::filesystem::is_empty(folder.path()));
}

namespace {

/// The surface's clip, and the camera, as Alembic files, one after the other.
std::string alembic_text(const std::vector<int>& frames, const MovingSurface& surface = tetrahedron()) {
  const TemporaryFolder folder;
  const ClipSpace clip{.fps = 30, .frames = frames};
  AlembicWriter writer(folder / (surface.name + ".abc"), surface, clip);
  for (const int frame : frames) writer.append(moved(surface, frame));
  writer.finish();
  write_alembic_camera(folder / "camera.abc", {.position = {5, 1, 2}, .target = {0, 1, 2}}, clip);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
  if (const char* kept = std::getenv("UMAX_KEEP_ALEMBIC"); kept && *kept)
    std::filesystem::copy(folder.path(), kept,
                          std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
  return test::AlembicText(read_file(folder / (surface.name + ".abc"))).text() +
         test::AlembicText(read_file(folder / "camera.abc")).text();
}

}  // namespace

TEST_CASE("Alembic files are what Alembic's own library has read in them", "[caches]") {
  // made of these very files by tests/clients/alembic_dump.cpp, with library 1.8.9
  CHECK(alembic_text({4, 6, 8}) ==
        read_file(std::filesystem::path(UMAX_SOURCE_DIR) / "tests/embedding/alembic_dump.txt"));
}

TEST_CASE("Alembic: several materials are sets of faces, as Alembic's own library has read them", "[caches]") {
  MovingSurface surface = tetrahedron();
  surface.name = "patchwork";
  surface.materials.resize(2);
  surface.materials[0].name = "skin";
  surface.materials[1].name = "plate";
  surface.triangle_materials = {1, 0, 1, 1};
  const std::string text = alembic_text({4, 6, 8}, surface);
  const std::size_t start = text.find("object /patchwork/patchworkShape/skin"), end = text.find("object /camera ");
  REQUIRE(start < end);
  CHECK(text.substr(start, end - start) ==
        read_file(std::filesystem::path(UMAX_SOURCE_DIR) / "tests/embedding/alembic_faces.txt"));
}

TEST_CASE("Alembic has any frames: one, at unequal distances, more than a byte counts", "[caches]") {
  CHECK(test::contains(alembic_text({7}), "array P: float32_t x 3, samples 1 constant, cycle 1, start 0.233333333"));
  CHECK(test::contains(alembic_text({1, 2, 4}), "samples 3, cycle 5.61779"));  // the largest double over 32: acyclic
  std::vector<int> many(300);
  std::iota(many.begin(), many.end(), 1);
  CHECK(test::contains(alembic_text(many), "samples 300, cycle 0.0333333333, start 0.0333333333"));
}

TEST_CASE("MurmurHash3 gives the keys that are known", "[caches]") {
  // of x64_128 with seed 0: nothing; and what Alembic's library had for these bytes
  CHECK(murmur_hash("") == Hash128{0, 0});
  CHECK(murmur_hash("\1") == Hash128{0x7ace5c908374fe16, 0x778867e4430e6785});
  const std::vector<int> corners{0, 2, 1};
  CHECK(murmur_hash({reinterpret_cast<const char*>(corners.data()), 12}) ==
        Hash128{0x9a421e45804fb453, 0x381c4ea2475e8b88});
}

TEST_CASE("USD: what is larger than a file should be becomes value clips that overlap by a frame", "[caches]") {
  const TemporaryFolder folder;
  const MovingSurface surface = tetrahedron();
  const ClipSpace clip{.fps = 30, .frames = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
  for (const long long largest : {5000LL, 1LL << 40}) {
    const bool is_small = largest > 5000;
    UsdaWriter writer(folder / "tetrahedron.usda", surface, clip, largest);
    for (const int frame : clip.frames) writer.append(moved(surface, frame));
    writer.finish();
    const std::string text = read_file(folder / "tetrahedron.usda");
    CHECK((writer.files().size() == 1) == is_small);
    CHECK(test::contains(text, "point3f[] points.timeSamples") == is_small);
    CHECK(test::contains(text, "clips = {") == !is_small);
    int num_samples = 0;
    for (const auto& file : writer.files()) {
      CHECK(std::filesystem::file_size(file) < (unsigned long long)(largest));
      const std::string layer = read_file(file);
      const std::size_t points = layer.find("point3f[] points.timeSamples"), end = layer.find("}", points);
      for (std::size_t at = points; points != layer.npos && (at = layer.find(": [", at + 1)) < end;) ++num_samples;
    }
    CHECK(num_samples == (is_small ? 12 : 12 + int(writer.files().size()) - 3));
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
    CHECK(entry.path().filename().string()[0] != '.');
}

TEST_CASE("names become those of prims", "[caches]") {
  CHECK(usd_name("cow") == "cow");
  CHECK(usd_name("obstacle.plate-2") == "obstacle_plate_2");
  CHECK(usd_name("2nd") == "_2nd");
}
