#include "embedding/caches/point_cache_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "embedding/caches/bytes.h"

namespace umax {
namespace {

constexpr std::string_view pc2_magic("POINTCACHE2\0", 12);
constexpr std::size_t pc2_header_size = 32, mdd_header_size = 8;
constexpr double least_frames = 0.5;  // of PC2's sampling: less is in seconds

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& what, const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = path.string(), .what = what, .remedy = remedy});
}

template <class T>
T value_at(std::string_view bytes, std::size_t at, bool big_endian) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, 4);
  return std::bit_cast<T>(big_endian ? swapped(word) : word);
}

// of a mesh file's vertices: all, and those that triangles have
struct VertexCounts {
  Eigen::Index all = 0, used = 0;
};

void require_counts(const std::filesystem::path& path, std::int32_t frames, std::int32_t vertices,
                    const VertexCounts& wanted) {
  if (frames < 1)
    refuse(path, fmt::format("has {} frames", frames), "export the animation again, with one frame at least");
  if (vertices < 1)
    refuse(path, fmt::format("has {} vertices", vertices), "export the animation again, of the mesh that moves");
  if (vertices != wanted.all && vertices != wanted.used)
    refuse(path, fmt::format("has {} vertices, but the mesh has {}", vertices, wanted.all),
           "give the mesh that was animated, in the same order of vertices and without modifiers that change their "
           "number");
}

void require_size(const std::filesystem::path& path, std::string_view bytes, std::size_t header, std::int32_t frames,
                  std::int32_t vertices) {
  const double of_frame = 12.0 * vertices, wanted = double(header) + frames * of_frame;
  if (double(bytes.size()) > wanted)
    refuse(path, fmt::format("goes on for {:.0f} bytes after its {} frames", double(bytes.size()) - wanted, frames),
           "export the animation again");
  if (double(bytes.size()) < wanted)
    refuse(path,
           fmt::format("is cut off: it says that it has {} frames, and ends in frame {:.0f}", frames,
                       1 + std::floor(std::max(0.0, double(bytes.size()) - double(header)) / of_frame)),
           "export the animation again");
}

void read_positions(std::string_view bytes, bool big_endian, PointSamples& samples) {
  samples.positions.resize(bytes.size() / 4);
  std::memcpy(samples.positions.data(), bytes.data(), bytes.size());
  if (!big_endian) return;
  for (float& value : samples.positions) value = std::bit_cast<float>(swapped(std::bit_cast<std::uint32_t>(value)));
}

PointSamples read_pc2(const std::filesystem::path& path, std::string_view bytes, const VertexCounts& wanted) {
  if (bytes.size() < pc2_header_size || bytes.substr(0, pc2_magic.size()) != pc2_magic)
    refuse(path, "is no PC2 file: it does not begin as one", "export the animation as PC2 or MDD");
  if (const auto version = value_at<std::int32_t>(bytes, 12, false); version != 1)
    refuse(path, fmt::format("is of version {} of PC2, which is not known", version), "export it as version 1, or MDD");
  const auto vertices = value_at<std::int32_t>(bytes, 16, false), frames = value_at<std::int32_t>(bytes, 28, false);
  const auto start = value_at<float>(bytes, 20, false), sampling = value_at<float>(bytes, 24, false);
  require_counts(path, frames, vertices, wanted);
  const auto refuse_times = [&] {
    refuse(path, fmt::format("starts at {:g} and has a frame every {:g}: no times", start, sampling),
           "export the animation again");
  };
  if (!std::isfinite(start) || !std::isfinite(sampling)) refuse_times();
  require_size(path, bytes, pc2_header_size, frames, vertices);
  PointSamples samples{
      .times = {}, .are_frames = double(sampling) >= least_frames, .num_vertices = vertices, .positions = {}};
  for (std::int32_t k = 0; k < frames; ++k) {
    const double time = double(start) + k * double(sampling);
    if (k > 0 && !(time > samples.times.back())) refuse_times();
    samples.times.push_back(time);
  }
  read_positions(bytes.substr(pc2_header_size), false, samples);
  return samples;
}

PointSamples read_mdd(const std::filesystem::path& path, std::string_view bytes, const VertexCounts& wanted) {
  if (bytes.size() < mdd_header_size) refuse(path, "is no MDD file: it is too short", "export the animation again");
  const auto frames = value_at<std::int32_t>(bytes, 0, true), vertices = value_at<std::int32_t>(bytes, 4, true);
  require_counts(path, frames, vertices, wanted);
  const std::size_t header = mdd_header_size + 4 * std::size_t(frames);
  require_size(path, bytes, header, frames, vertices);
  PointSamples samples{.times = {}, .are_frames = false, .num_vertices = vertices, .positions = {}};
  for (std::int32_t k = 0; k < frames; ++k) {
    const double time = double(value_at<float>(bytes, mdd_header_size + 4 * std::size_t(k), true));
    if (!std::isfinite(time) || (k > 0 && !(time > samples.times.back())))
      refuse(path,
             fmt::format("has frame {} at {:g} s{}", k + 1, time,
                         k > 0 ? fmt::format(", after one at {:g} s: times must increase", samples.times.back()) : ""),
             "export the animation again");
    samples.times.push_back(time);
  }
  read_positions(bytes.substr(header), true, samples);
  return samples;
}

// the longest time between neighbours that occurs often, or the shortest where none does
double usual_interval(const std::vector<double>& times) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < times.size(); ++k) intervals.push_back(times[k] - times[k - 1]);
  std::sort(intervals.begin(), intervals.end());
  const std::size_t often = std::max<std::size_t>(2, intervals.size() / 10);
  constexpr double alike = 1.01;
  double usual = intervals.front();
  for (std::size_t k = 0; k + often <= intervals.size(); ++k)
    if (intervals[k + often - 1] <= alike * intervals[k]) usual = intervals[k + often - 1];
  return usual;
}

}  // namespace

bool is_point_cache(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = char(std::tolower(static_cast<unsigned char>(c)));
  return ending == ".pc2" || ending == ".mdd";
}

PointSamples read_point_cache(const std::filesystem::path& path, Eigen::Index num_vertices, Eigen::Index num_used) {
  const VertexCounts wanted{num_vertices, num_used < 0 ? num_vertices : num_used};
  const std::string bytes = read_file(path);
  const bool is_mdd = path.extension().string().size() == 4 && std::tolower(path.extension().string()[1]) == 'm';
  PointSamples samples = is_mdd ? read_mdd(path, bytes, wanted) : read_pc2(path, bytes, wanted);
  for (std::size_t k = 0; k < samples.times.size(); ++k) require_finite_sample(path, samples, k);
  return samples;
}

void require_finite_sample(const std::filesystem::path& path, const PointSamples& samples, std::size_t instant) {
  constexpr float absurd = 1e9F;
  const std::size_t count = std::size_t(3 * samples.num_vertices);
  const float* values = samples.positions.data() + instant * count;
  for (std::size_t i = 0; i < count; ++i)
    if (!(std::abs(values[i]) <= absurd))
      throw Error(Fault::bad_data, {.where = path.string(),
                                    .what = fmt::format("has a coordinate that is no number or beyond 1e9: vertex {} "
                                                        "in frame {}",
                                                        i / 3, instant + 1),
                                    .value = fmt::format("{:g}", values[i]),
                                    .remedy = "export the animation again"});
}

int find_gap(const std::vector<double>& times, double frame) {
  constexpr double longer = 1.5;
  if (times.size() < 3) return -1;
  const double usual = std::max(usual_interval(times), frame);
  for (std::size_t k = 1; k < times.size(); ++k)
    if (times[k] - times[k - 1] > longer * usual) return int(k) - 1;
  return -1;
}

}  // namespace umax
