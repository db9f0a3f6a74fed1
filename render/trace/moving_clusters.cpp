#include "render/trace/moving_clusters.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"

namespace umax {
namespace {

// what is between two instants is rounded here and in the library: boxes have room to spare, as a share of the largest
// coordinate that the cluster ever has
constexpr float rounding = 1e-6f;

void copy_positions(const TracedObject::Vertex* vertices, const TriangleCluster& cluster, ClusterPositions& to) {
  for (int j = 0; j < cluster_size; ++j) {
    const float* from = vertices[cluster.vertices[j]].position;
    for (int c = 0; c < 3; ++c) to.of_axis[c][j] = from[c];
  }
}

float largest_coordinate(const ClusterPositions* positions, std::size_t num_instants) {
  float largest = 0;
  for (std::size_t k = 0; k < num_instants; ++k)
    for (const auto& row : positions[k].of_axis)
      for (const float x : row) largest = std::max(largest, std::abs(x));
  return largest;
}

MovingClusters::Box box_around(const ClusterPositions& positions, float margin) {
  MovingClusters::Box box;
  for (int c = 0; c < 3; ++c) {
    const auto& row = positions.of_axis[c];
    float low = row[0], high = row[0];
    for (const float x : row) low = std::min(low, x), high = std::max(high, x);
    box.low[c] = low - margin;
    box.high[c] = high + margin;
  }
  return box;
}

// a step takes in two of the straight parts of the way: that halves what the library needs for its hierarchy
std::size_t steps_for(int num_instants) {
  return std::size_t(std::max(1, (num_instants - 1) / 2)) + 1;
}

// the instants at which the way bends, while the shutter is open
std::vector<float> bends_of(const InstantTimes& times) {
  std::vector<float> bends;
  for (int k = 0; k < times.num_instants; ++k)
    if (const float time = times.time_of(k); time > 0 && time < 1) bends.push_back(time);
  return bends;
}

}  // namespace

MovingClusters::MovingClusters(const TracedObject& object, std::shared_ptr<const TriangleClusters> clusters)
    : clusters_(std::move(clusters)), times_(object.instants), num_steps_(steps_for(object.instants.num_instants)) {
  positions_ = std::make_unique_for_overwrite<ClusterPositions[]>(count() * num_instants());
  boxes_.resize(count() * num_steps_);
  const std::vector<float> bends = bends_of(times_);
  constexpr Eigen::Index grain = 512;
  parallel_blocks(Eigen::Index(count()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (std::size_t k = 0; k < num_instants(); ++k)
      for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i)
        copy_positions(object.vertices.data() + k * object.num_vertices, (*clusters_)[i],
                       positions_[i * num_instants() + k]);
    for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) find_boxes(i, bends);
  });
}

// Between two bends every vertex goes straight, and so a box that holds them at both ends holds them on the way.
void MovingClusters::find_boxes(std::size_t cluster, const std::vector<float>& bends) {
  Box* boxes = &boxes_[cluster * num_steps_];
  const float last = float(num_steps_ - 1);
  const float margin = rounding * largest_coordinate(&positions_[cluster * num_instants()], num_instants());
  for (std::size_t step = 0; step < num_steps_; ++step)
    boxes[step] = box_around(positions_at(cluster, float(step) / last), margin);
  for (const float bend : bends) {
    const float place = bend * last;
    const std::size_t step = std::min(std::size_t(place), num_steps_ - 2);
    const float share = place - float(step);
    const Box there = box_around(positions_at(cluster, bend), margin);
    Box &before = boxes[step], &after = boxes[step + 1];
    for (int c = 0; c < 3; ++c) {
      const float lack_low = (1 - share) * before.low[c] + share * after.low[c] - there.low[c],
                  lack_high = there.high[c] - (1 - share) * before.high[c] - share * after.high[c];
      if (lack_low > 0) before.low[c] -= lack_low, after.low[c] -= lack_low;
      if (lack_high > 0) before.high[c] += lack_high, after.high[c] += lack_high;
    }
  }
}

ClusterPositions MovingClusters::positions_at(std::size_t cluster, float time) const {
  const InstantTimes::Place place = times_.at(time);
  const ClusterPositions* before = &positions_[cluster * num_instants() + std::size_t(place.segment)];
  ClusterPositions between;
  for (int c = 0; c < 3; ++c)
    for (int j = 0; j < cluster_size; ++j)
      between.of_axis[c][j] = (1 - place.share) * before[0].of_axis[c][j] + place.share * before[1].of_axis[c][j];
  return between;
}

}  // namespace umax
