#include "core/model/mesh_motion.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index vertices_per_block = 4096;

auto sample_of(const MeshMotion& motion, std::size_t k) {
  using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
  return Eigen::Map<const FloatRows>(motion.samples.data() + k * std::size_t(3 * motion.num_vertices),
                                     motion.num_vertices, 3);
}

}  // namespace

double time_within(const MeshMotion& motion, double time) {
  return std::clamp(time, motion.times.front(), motion.times.back());
}

Points positions_at(const MeshMotion& motion, double time) {
  assert(!motion.times.empty());
  const double at = time_within(motion, time);
  const auto after = std::upper_bound(motion.times.begin(), motion.times.end(), at);
  const std::size_t next = std::size_t(std::min(after - motion.times.begin(), std::ptrdiff_t(motion.times.size()) - 1));
  const std::size_t last = next > 0 ? next - 1 : 0;
  const double share = next > last ? (at - motion.times[last]) / (motion.times[next] - motion.times[last]) : 0;
  const auto from = sample_of(motion, last), to = sample_of(motion, next);
  Points positions(motion.num_vertices, 3);
  parallel_blocks(motion.num_vertices, vertices_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index v = begin; v < end; ++v) {
      const Vector3d own =
          (1 - share) * from.row(v).cast<double>().transpose() + share * to.row(v).cast<double>().transpose();
      positions.row(v) = (motion.placed_from_own * own).transpose();
    }
  });
  return positions;
}

double largest_speed(const MeshMotion& motion) {
  double largest = 0;
  for (std::size_t k = 1; k < motion.times.size(); ++k) {
    const auto moves = (sample_of(motion, k) - sample_of(motion, k - 1)).cast<double>();
    const double way =
        std::sqrt((moves * motion.placed_from_own.linear().transpose()).rowwise().squaredNorm().maxCoeff());
    largest = std::max(largest, way / (motion.times[k] - motion.times[k - 1]));
  }
  return largest;
}

}  // namespace umax
