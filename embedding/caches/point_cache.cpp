#include "embedding/caches/point_cache.h"

#include <fmt/format.h>

#include <cassert>
#include <limits>

#include "core/base/error.h"
#include "embedding/caches/bytes.h"

namespace umax {
namespace {

/// What PC2 says of its frames.
struct Sampling {
  float start = 0, step = 0;  // [s]
};

Sampling sampling_of(const std::filesystem::path& path, const ClipSpace& clip) {
  if (!is_evenly_spaced(clip.frames))
    throw Error(Fault::bad_data, {.where = path.string(),
                                  .what = "PC2 holds frames at equal distances only",
                                  .remedy = "give such --frames (1-40, 1-99x2), or export mdd, which holds any"});
  const int step = clip.frames.size() > 1 ? clip.frames[1] - clip.frames[0] : 1;
  return {float(clip.time_of(clip.frames.front())), float(step / clip.fps)};
}

std::string pc2_header(const std::filesystem::path& path, std::int32_t num_vertices, const ClipSpace& clip) {
  const Sampling sampling = sampling_of(path, clip);
  std::string header("POINTCACHE2\0", 12);
  append_bytes(header, std::int32_t(1));
  append_bytes(header, num_vertices);
  append_bytes(header, sampling.start);
  append_bytes(header, sampling.step);
  append_bytes(header, std::int32_t(clip.frames.size()));
  return header;
}

std::string mdd_header(std::int32_t num_vertices, const ClipSpace& clip) {
  std::string header;
  append_big_endian(header, std::uint32_t(clip.frames.size()));
  append_big_endian(header, std::uint32_t(num_vertices));
  for (const int frame : clip.frames) append_big_endian(header, float(clip.time_of(frame)));
  return header;
}

}  // namespace

bool is_evenly_spaced(const std::vector<int>& frames) {
  for (std::size_t i = 2; i < frames.size(); ++i)
    if (frames[i] - frames[i - 1] != frames[1] - frames[0]) return false;
  return true;
}

PointCacheWriter::PointCacheWriter(const std::filesystem::path& path, PointCacheKind kind, Eigen::Index num_vertices,
                                   const ClipSpace& clip)
    : file_(path), kind_(kind), num_vertices_(num_vertices), num_frames_(clip.frames.size()) {
  assert(num_vertices <= std::numeric_limits<std::int32_t>::max());
  const auto count = std::int32_t(num_vertices);
  file_.write(kind == PointCacheKind::pc2 ? pc2_header(path, count, clip) : mdd_header(count, clip));
}

void PointCacheWriter::append(const SurfaceFrame& frame) {
  assert(frame.positions.rows() == num_vertices_ && written_ < num_frames_);
  ++written_;
  const std::string_view bytes = bytes_of(frame.positions);
  if (kind_ == PointCacheKind::pc2) {
    file_.write(bytes);
    return;
  }
  swapped_.resize(bytes.size());
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, 4);
    word = swapped(word);
    std::memcpy(swapped_.data() + at, &word, 4);
  }
  file_.write({swapped_.data(), swapped_.size()});
}

void PointCacheWriter::finish() {
  assert(written_ == num_frames_);
  file_.finish();
}

}  // namespace umax
