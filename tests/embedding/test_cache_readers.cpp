// Animations of other programs: what is read is what was written, and what is damaged is refused before it is used.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "core/files/read_file.h"
#include "embedding/caches/point_cache.h"
#include "embedding/caches/point_cache_reader.h"
#include "embedding/caches/sequence_files.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
using test::contains;
using test::failure_of;

namespace {

FloatPoints frame_points(int frame) {
  FloatPoints points(4, 3);
  points << 0, 0, 0, 1.25f, 0, 0, 0, 1.1f, 0, 0, 0, 0.3f;
  return points.array() + 0.37f * float(frame);
}

std::filesystem::path write_cache(const std::filesystem::path& path, PointCacheKind kind,
                                  const std::vector<int>& frames) {
  const ClipSpace clip{.fps = 25, .frames = frames};
  PointCacheWriter writer(path, kind, 4, clip);
  for (const int frame : frames) {
    SurfaceFrame out;
    out.frame = frame;
    out.positions = frame_points(frame);
    writer.append(out);
  }
  writer.finish();
  return path;
}

void put(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// a number as the file has it; MDD: the other way round
template <class T>
void patch(std::string& bytes, std::size_t at, T value, bool big_endian) {
  char word[4];
  std::memcpy(word, &value, 4);
  if (big_endian) std::reverse(word, word + 4);
  bytes.replace(at, 4, word, 4);
}

}  // namespace

TEST_CASE("point caches come back as they went out", "[caches]") {
  const TemporaryFolder folder;
  for (const bool is_mdd : {false, true}) {
    const auto path = write_cache(folder / (is_mdd ? "a.mdd" : "a.pc2"),
                                  is_mdd ? PointCacheKind::mdd : PointCacheKind::pc2, {1, 2, 3, 4, 5});
    const PointSamples samples = read_point_cache(path, 4);
    REQUIRE(samples.times.size() == 5);
    CHECK_FALSE(samples.are_frames);
    CHECK(samples.num_vertices == 4);
    REQUIRE(samples.positions.size() == 60);
    for (int k = 0; k < 5; ++k) {
      CHECK(samples.times[std::size_t(k)] == Approx(k / 25.0).margin(1e-7));
      CHECK(std::memcmp(samples.positions.data() + 12 * k, frame_points(k + 1).eval().data(), 48) == 0);
    }
  }
}

TEST_CASE("a PC2 that counts in frames is told from one in seconds", "[caches]") {
  const TemporaryFolder folder;
  std::string bytes = read_file(write_cache(folder / "a.pc2", PointCacheKind::pc2, {1, 2, 3}));
  patch(bytes, 20, 1.0F, false);  // start
  patch(bytes, 24, 1.0F, false);  // sampling
  put(folder / "b.pc2", bytes);
  const PointSamples samples = read_point_cache(folder / "b.pc2", 4);
  CHECK(samples.are_frames);
  CHECK(samples.times == std::vector<double>{1, 2, 3});
}

TEST_CASE("damaged point caches are refused, and it is said why", "[caches]") {
  const TemporaryFolder folder;
  const bool is_mdd = GENERATE(false, true);
  const auto path = folder / (is_mdd ? "a.mdd" : "a.pc2");
  const std::string whole = read_file(write_cache(path, is_mdd ? PointCacheKind::mdd : PointCacheKind::pc2, {1, 2, 3}));
  const auto complaint = [&](const std::string& bytes, Eigen::Index vertices = 4) {
    put(path, bytes);
    const auto failure = failure_of([&] { read_point_cache(path, vertices); });
    CHECK(failure.code == 65);
    CHECK(contains(failure.where, path.filename().string()));
    CHECK(!failure.remedy.empty());
    return failure.what + " " + failure.value;
  };
  const std::size_t data = is_mdd ? 8 + 3 * 4 : 32, frames_at = is_mdd ? 0 : 28;
  CHECK(contains(complaint(whole.substr(0, whole.size() - 1)),
                 "is cut off: it says that it has 3 frames, and ends in frame 3"));
  CHECK(contains(complaint(whole.substr(0, data + 50)), "ends in frame 2"));
  CHECK(contains(complaint(whole + "x"), "goes on for 1 bytes after its 3 frames"));
  CHECK(contains(complaint(whole, 5), "has 4 vertices, but the mesh has 5"));
  std::string changed = whole;
  patch(changed, frames_at, std::int32_t(0), is_mdd);
  CHECK(contains(complaint(changed), "has 0 frames"));
  patch(changed, frames_at, std::int32_t(-7), is_mdd);
  CHECK(contains(complaint(changed), "has -7 frames"));
  patch(changed, frames_at, std::int32_t(2000000000), is_mdd);
  CHECK(contains(complaint(changed), "is cut off"));
  changed = whole;
  patch(changed, data + 48 + 16, std::numeric_limits<float>::quiet_NaN(), is_mdd);
  CHECK(contains(complaint(changed), "vertex 1 in frame 2"));
  patch(changed, data + 48 + 16, 3e9F, is_mdd);
  CHECK(contains(complaint(changed), "beyond 1e9"));
  for (const std::size_t size : {0, 3, 7, 13, 31}) complaint(whole.substr(0, size));
  if (is_mdd) {
    changed = whole;
    patch(changed, 8 + 2 * 4, 0.01F, true);
    CHECK(contains(complaint(changed), "has frame 3 at 0.01 s, after one at 0.04 s"));
  } else {
    changed = whole;
    patch(changed, 24, 0.0F, false);
    CHECK(contains(complaint(changed), "has a frame every 0"));
    patch(changed, 12, std::int32_t(3), false);
    CHECK(contains(complaint(changed), "version 3"));
    CHECK(contains(complaint("POINTCACHE3" + whole.substr(11)), "is no PC2 file"));
  }
  CHECK(failure_of([&] { read_point_cache(folder / "none.pc2", 4); }).code == 66);
}

TEST_CASE("a gap in an animation's times is found, instants between frames are none", "[caches]") {
  CHECK(find_gap({0}, 0.04) == -1);
  CHECK(find_gap({0, 7}, 0.04) == -1);
  CHECK(find_gap({0, 0.04, 0.08, 0.5, 0.54}, 1 / 60.0) == 2);
  CHECK(find_gap({0, 0.04, 0.5}, 0.04) == 1);
  CHECK(find_gap({0, 0.04, 0.08, 0.16, 0.2, 0.24}, 0.04) == 2);  // one frame is missing
  CHECK(find_gap({0, 1, 2, 3}, 0.04) == -1);                     // a slow animation
  std::vector<double> finer;                                     // a quarter of a frame where it is fast
  for (int k = 0; k < 20; ++k) finer.push_back(k * 0.01);
  for (int k = 0; k < 20; ++k) finer.push_back(finer.back() + 0.04);
  CHECK(find_gap(finer, 0.04) == -1);
  CHECK(find_gap({0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.12}, 0.04) == -1);
}

TEST_CASE("a folder's meshes are put in order by their numbers, and what is not one animation is refused", "[caches]") {
  const TemporaryFolder folder;
  const auto complaint = [&] {
    const auto failure = failure_of([&] { find_sequence(folder.path()); });
    CHECK(failure.code == 65);
    CHECK(!failure.remedy.empty());
    return failure.what;
  };
  CHECK(contains(complaint(), "holds no OBJ or PLY files"));
  for (const int number : {9, 10, 11}) put(folder / fmt::format("walk_{}.obj", number), "v 0 0 0\n");
  put(folder / "walk.mtl", "");
  const auto sequence = find_sequence(folder.path());
  REQUIRE(sequence.size() == 3);
  CHECK(sequence[0].frame == 9);
  CHECK(sequence[2].path.filename() == "walk_11.obj");
  const std::string digest = sha256_of_cache(folder.path());
  put(folder / "walk_11.obj", "v 0 0 1\n");
  CHECK(sha256_of_cache(folder.path()) != digest);

  put(folder / "walk_13.obj", "v 0 0 0\n");
  CHECK(contains(complaint(), "frame 12 is missing between walk_11.obj and walk_13.obj"));
  std::filesystem::remove(folder / "walk_13.obj");
  put(folder / "walk_0010.obj", "v 0 0 0\n");
  CHECK(contains(complaint(), "frame 10 twice"));
  std::filesystem::remove(folder / "walk_0010.obj");
  put(folder / "run_12.obj", "v 0 0 0\n");
  CHECK(contains(complaint(), "more than one animation"));
  std::filesystem::rename(folder / "run_12.obj", folder / "walk_12.ply");
  CHECK(contains(complaint(), "more than one animation"));
  std::filesystem::rename(folder / "walk_12.ply", folder / "last.obj");
  CHECK(contains(complaint(), "does not end with the number of a frame: last.obj"));
  CHECK(failure_of([&] { find_sequence(folder / "none"); }).code == 66);
}
