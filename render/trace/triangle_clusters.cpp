#include "render/trace/triangle_clusters.h"

#include <algorithm>

namespace umax {
namespace {

using Corners = TracedObject::Corners;

// the triangles around each vertex
struct Fans {
  std::vector<unsigned> start, triangles;

  Fans(const std::vector<Corners>& corners, std::size_t num_vertices) : start(num_vertices + 1, 0) {
    for (const Corners& triangle : corners)
      for (const unsigned vertex : triangle.index) ++start[vertex + 1];
    for (std::size_t i = 0; i < num_vertices; ++i) start[i + 1] += start[i];
    triangles.resize(3 * corners.size());
    std::vector<unsigned> next(start.begin(), start.end() - 1);
    for (std::size_t t = 0; t < corners.size(); ++t)
      for (const unsigned vertex : corners[t].index) triangles[next[vertex]++] = unsigned(t);
  }
};

// Grows clusters one after the other: from a triangle at the edge of what is done, always by the neighbour that brings
// the fewest vertices and, of those, the one that has the fewest triangles left around it, so that none are left alone.
class Grower {
 public:
  Grower(const std::vector<Corners>& triangles, std::size_t num_vertices)
      : corners_(triangles),
        fans_(triangles, num_vertices),
        left_(num_vertices),
        first_left_(fans_.start.begin(), fans_.start.end() - 1),
        is_done_(triangles.size(), 0),
        place_(num_vertices, -1) {
    for (std::size_t i = 0; i < num_vertices; ++i) left_[i] = fans_.start[i + 1] - fans_.start[i];
  }

  TriangleClusters grow() {
    TriangleClusters clusters;
    unsigned first = 0;
    while (true) {
      unsigned seed = from_edge();
      if (seed == none) {
        while (first < corners_.size() && is_done_[first]) ++first;
        if (first == corners_.size()) break;
        seed = first;
      }
      clusters.push_back(cluster_from(seed));
    }
    return clusters;
  }

 private:
  static constexpr unsigned none = ~0u;

  // Calls visit(t) for the triangles around a vertex that are in no cluster yet: for all, or where they are so many that
  // looking at all each time would take long, for the first few. Their other corners show which of those lie next.
  template <class Visit>
  void for_each_left(unsigned vertex, const Visit& visit) {
    constexpr unsigned many = 1024, few = 64;
    unsigned &first = first_left_[vertex], last = fans_.start[vertex + 1];
    while (first < last && is_done_[fans_.triangles[first]]) ++first;
    if (last - fans_.start[vertex] > many) last = std::min(last, first + few);
    for (unsigned k = first; k < last; ++k)
      if (const unsigned t = fans_.triangles[k]; !is_done_[t]) visit(t);
  }

  // among the neighbours of the last cluster
  unsigned from_edge() {
    unsigned best = none, fewest = none;
    for (const unsigned vertex : vertices_)
      for_each_left(vertex, [&](unsigned t) {
        if (left_around(t) < fewest) best = t, fewest = left_around(t);
      });
    return best;
  }

  unsigned left_around(unsigned triangle) const {
    const auto& index = corners_[triangle].index;
    return left_[index[0]] + left_[index[1]] + left_[index[2]];
  }

  int num_new(unsigned triangle) const {
    const auto& index = corners_[triangle].index;
    const bool second = index[1] != index[0], third = index[2] != index[0] && index[2] != index[1];
    return int(place_[index[0]] < 0) + int(second && place_[index[1]] < 0) + int(third && place_[index[2]] < 0);
  }

  unsigned best_neighbour() {
    unsigned best = none, least = none;
    for (const unsigned vertex : vertices_)
      for_each_left(vertex, [&](unsigned t) {
        const int added = num_new(t);
        if (int(vertices_.size()) + added > cluster_size) return;
        const unsigned cost = unsigned(added) * 4096 + std::min(left_around(t), 4095u);
        if (cost < least) best = t, least = cost;
      });
    return best;
  }

  void add(unsigned triangle) {
    is_done_[triangle] = 1;
    triangles_.push_back(triangle);
    for (const unsigned vertex : corners_[triangle].index) {
      --left_[vertex];
      if (place_[vertex] >= 0) continue;
      place_[vertex] = int(vertices_.size());
      vertices_.push_back(vertex);
    }
  }

  TriangleCluster cluster_from(unsigned seed) {
    triangles_.clear();
    vertices_.clear();
    for (unsigned t = seed; t != none; t = int(triangles_.size()) < cluster_size ? best_neighbour() : none) add(t);
    std::sort(triangles_.begin(), triangles_.end());
    TriangleCluster cluster;
    for (std::size_t i = 0; i < std::size_t(cluster_size); ++i) {
      cluster.triangles[i] = triangles_[std::min(i, triangles_.size() - 1)];
      cluster.vertices[i] = vertices_[std::min(i, vertices_.size() - 1)];
      for (int c = 0; c < 3; ++c)
        cluster.corners.places[c][i] = static_cast<unsigned char>(place_[corners_[cluster.triangles[i]].index[c]]);
    }
    for (const unsigned vertex : vertices_) place_[vertex] = -1;
    return cluster;
  }

  const std::vector<Corners>& corners_;
  Fans fans_;
  std::vector<unsigned> left_;        // triangles around each vertex that are in no cluster yet
  std::vector<unsigned> first_left_;  // of each vertex's fan: none before is left
  std::vector<char> is_done_;
  std::vector<int> place_;  // of each vertex in the cluster that grows, or -1
  std::vector<unsigned> triangles_, vertices_;
};

}  // namespace

TriangleClusters make_clusters(const std::vector<Corners>& triangles, std::size_t num_vertices) {
  return Grower(triangles, num_vertices).grow();
}

std::shared_ptr<const TriangleClusters> ClusterCache::clusters_of(const TracedObject& object) {
  constexpr std::size_t most_entries = 64;
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.num_vertices == object.num_vertices && entry.triangles == object.triangles;
  });
  if (found != entries_.end()) {
    std::rotate(entries_.begin(), found, found + 1);
  } else {
    if (entries_.size() == most_entries) entries_.pop_back();
    entries_.insert(entries_.begin(),
                    {object.triangles, object.num_vertices,
                     std::make_shared<const TriangleClusters>(make_clusters(object.triangles, object.num_vertices))});
  }
  return entries_.front().clusters;
}

}  // namespace umax
