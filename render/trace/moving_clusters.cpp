#include "render/trace/moving_clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/parallel.h"

namespace umax {
namespace {

// what is between two instants is rounded here and in the library: boxes have room to spare, as a share of the largest
// coordinate that the cluster ever has
constexpr float rounding = 1e-6f;

// boxes that a ray through an object comes through, on average: where they are more, it is cut into parts
constexpr double many_triangles = 512, many_clusters = 64;
constexpr float parts_along = 64;  // an object

double half_area(const MovingClusters::Box& box) {
  const double x = double(box.high[0]) - double(box.low[0]), y = double(box.high[1]) - double(box.low[1]),
               z = double(box.high[2]) - double(box.low[2]);
  return x * y + y * z + z * x;
}

MovingClusters::Box no_box() {
  constexpr float far = std::numeric_limits<float>::max();
  return {.low = {far, far, far}, .high = {-far, -far, -far}};
}

int longest_axis(const MovingClusters::Box& box) {
  int axis = 0;
  for (int c = 1; c < 3; ++c)
    if (box.high[c] - box.low[c] > box.high[axis] - box.low[axis]) axis = c;
  return axis;
}

void extend(MovingClusters::Box& box, const float low[3], const float high[3]) {
  for (int c = 0; c < 3; ++c) {
    box.low[c] = std::min(box.low[c], low[c]);
    box.high[c] = std::max(box.high[c], high[c]);
  }
}

// boxes that lie over each other, and one around all of them
struct Pile {
  MovingClusters::Box all = no_box();
  double areas = 0;  // [m^2] half of theirs

  void add(const MovingClusters::Box& box) {
    extend(all, box.low, box.high);
    areas += half_area(box);
  }
  // does a ray through all of them come through more of them than that, on average?
  bool is_higher_than(double count) const { return areas > count * half_area(all); }
};

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
  positions_ = std::make_unique_for_overwrite<ClusterPositions[]>(clusters_->size() * num_instants());
  constexpr Eigen::Index grain = 512;
  parallel_blocks(Eigen::Index(clusters_->size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (std::size_t k = 0; k < num_instants(); ++k)
      for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i)
        copy_positions(object.vertices.data() + k * object.num_vertices, (*clusters_)[i],
                       positions_[i * num_instants() + k]);
  });
  find_parts();
  boxes_.resize(count() * num_steps_);
  const std::vector<float> bends = bends_of(times_);
  parallel_blocks(Eigen::Index(count()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) find_boxes(i, bends);
  });
}

void MovingClusters::find_parts() {
  std::vector<Box> boxes;  // at the first instant
  Pile pile;
  for (std::size_t i = 0; i < clusters_->size(); ++i) {
    boxes.push_back(box_around(positions_[i * num_instants()], 0));
    pile.add(boxes.back());
  }
  const bool in_slices = pile.is_higher_than(many_clusters);
  const int longest = longest_axis(pile.all);
  const float size = (pile.all.high[longest] - pile.all.low[longest]) / parts_along;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box& box = boxes[i];
    const int axis = longest_axis(box);
    const int num_parts = in_slices ? int(std::ceil((box.high[axis] - box.low[axis]) / size)) : 1;
    if (num_parts <= 1) {
      parts_.push_back({.cluster = unsigned(i)});
      continue;
    }
    const auto cut = [&](int k) {
      const float share = float(k) / float(num_parts);
      return (1 - share) * box.low[axis] + share * box.high[axis];
    };
    for (int k = 0; k < num_parts; ++k)
      parts_.push_back({.cluster = unsigned(i), .axis = axis, .from = cut(k), .to = cut(k + 1)});
  }
}

// Of what the part has of each triangle, the corners: they go straight where the vertices do, and hold the rest.
std::vector<MovingClusters::EdgePoint> MovingClusters::corners_of(const Part& part) const {
  std::vector<EdgePoint> corners;
  if (part.axis == Part::whole) return corners;
  const auto& at = positions_[part.cluster * num_instants()].of_axis[part.axis];
  const TriangleCluster& cluster = (*clusters_)[part.cluster];
  for (int t = 0; t < cluster_size; ++t) {
    if (t > 0 && cluster.triangles[t] == cluster.triangles[t - 1]) break;
    for (int c = 0; c < 3; ++c) {
      const int a = cluster.corners.places[c][t], b = cluster.corners.places[(c + 1) % 3][t];
      if (at[a] >= part.from && at[a] <= part.to) corners.push_back({a, a, 0});
      for (const float cut : {part.from, part.to})
        if ((at[a] < cut) != (at[b] < cut)) corners.push_back({a, b, (cut - at[a]) / (at[b] - at[a])});
    }
  }
  return corners;
}

MovingClusters::Box MovingClusters::box_at(const Part& part, const std::vector<EdgePoint>& corners, float time,
                                           float margin) const {
  const ClusterPositions positions = positions_at(part.cluster, time);
  if (corners.empty()) return box_around(positions, margin);
  Box box = no_box();
  for (const EdgePoint& corner : corners) {
    float place[3];
    for (int c = 0; c < 3; ++c)
      place[c] = (1 - corner.share) * positions.of_axis[c][corner.a] + corner.share * positions.of_axis[c][corner.b];
    extend(box, place, place);
  }
  for (int c = 0; c < 3; ++c) box.low[c] -= margin, box.high[c] += margin;
  return box;
}

// Between two bends every vertex goes straight, and so a box that holds them at both ends holds them on the way.
void MovingClusters::find_boxes(std::size_t part_number, const std::vector<float>& bends) {
  const Part& part = parts_[part_number];
  const std::vector<EdgePoint> corners = corners_of(part);
  Box* boxes = &boxes_[part_number * num_steps_];
  const float last = float(num_steps_ - 1);
  const float margin = rounding * largest_coordinate(&positions_[part.cluster * num_instants()], num_instants());
  for (std::size_t step = 0; step < num_steps_; ++step) boxes[step] = box_at(part, corners, float(step) / last, margin);
  for (const float bend : bends) {
    const float place = bend * last;
    const std::size_t step = std::min(std::size_t(place), num_steps_ - 2);
    const float share = place - float(step);
    const Box there = box_at(part, corners, bend, margin);
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
  if (num_instants() == 1) return positions_[cluster];
  const InstantTimes::Place place = times_.at(time);
  const ClusterPositions* before = &positions_[cluster * num_instants() + std::size_t(place.segment)];
  ClusterPositions between;
  for (int c = 0; c < 3; ++c)
    for (int j = 0; j < cluster_size; ++j)
      between.of_axis[c][j] = (1 - place.share) * before[0].of_axis[c][j] + place.share * before[1].of_axis[c][j];
  return between;
}

bool is_sliced(const TracedObject& object) {
  Pile pile;
  for (const TracedObject::Corners& triangle : object.triangles) {
    MovingClusters::Box box = no_box();
    for (const unsigned vertex : triangle.index) {
      const float* place = object.vertices[vertex].position;
      extend(box, place, place);
    }
    pile.add(box);
  }
  return pile.is_higher_than(many_triangles);
}

}  // namespace umax
