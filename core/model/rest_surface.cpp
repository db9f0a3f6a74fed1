#include "core/model/rest_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr int leaf_size = 4;
constexpr double needle = 1e-6;       // [-] height over longest edge; the normals of flatter triangles are rounding
constexpr int cache_intervals = 128;  // of the cache, along the longest side

// Vertices at one place become one: seams of texture coordinates must not be edges.
void weld(const Points& vertices, const Triangles& triangles, RestSurface& surface) {
  std::vector<int> sorted(std::size_t(vertices.rows()));
  std::iota(sorted.begin(), sorted.end(), 0);
  const auto place = [&](int v) { return std::array{vertices(v, 0), vertices(v, 1), vertices(v, 2)}; };
  std::sort(sorted.begin(), sorted.end(),
            [&](int a, int b) { return place(a) != place(b) ? place(a) < place(b) : a < b; });
  std::vector<int> first(sorted.size());  // of the vertices at the same place
  for (std::size_t i = 0; i < sorted.size(); ++i)
    first[sorted[i]] = i > 0 && place(sorted[i]) == place(sorted[i - 1]) ? first[sorted[i - 1]] : sorted[i];
  surface.vertices = vertices;
  surface.triangles.resize(triangles.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Vector3i corners(first[triangles(t, 0)], first[triangles(t, 1)], first[triangles(t, 2)]);
    const Vector3d a = vertices.row(corners[0]).transpose(), b = vertices.row(corners[1]).transpose(),
                   c = vertices.row(corners[2]).transpose();
    if ((b - a).cross(c - a).squaredNorm() > 0) surface.triangles.row(count++) = corners.transpose();
  }
  surface.triangles.conservativeResize(count, 3);
}

struct HalfEdge {
  std::array<int, 2> vertices;  // ascending
  int slot;                     // 3 t + k
};

// by their vertices, then by slot
std::vector<HalfEdge> sorted_edges(const RestSurface& surface) {
  std::vector<HalfEdge> edges;
  edges.reserve(std::size_t(3 * surface.triangles.rows()));
  for (int t = 0; t < int(surface.triangles.rows()); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(surface.triangles(t, k), surface.triangles(t, (k + 1) % 3));
      edges.push_back({{low, high}, 3 * t + k});
    }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.vertices != b.vertices ? a.vertices < b.vertices : a.slot < b.slot;
  });
  return edges;
}

// Calls visit(slot, sum of the normals of the triangles at its edge) for each half edge.
template <class Visit>
void for_each_edge_sum(const std::vector<HalfEdge>& edges, const Points& normals, const Visit& visit) {
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (end = begin; end < edges.size() && edges[end].vertices == edges[begin].vertices; ++end)
      sum += normals.row(edges[end].slot / 3);
    for (std::size_t i = begin; i < end; ++i) visit(edges[i].slot, sum);
  }
}

// unit, or zero where the sum is rounding
Eigen::RowVector3d direction_of(const Eigen::RowVector3d& sum) {
  constexpr double rounding = 1e-9;
  const double length = sum.norm();
  return length > rounding ? Eigen::RowVector3d(sum / length) : Eigen::RowVector3d::Zero();
}

// Needles have the mean normal of their neighbours; those between needles, as soon as a neighbour has one.
void mend_needles(const std::vector<HalfEdge>& edges, std::vector<int> needles, Points& normals) {
  const Points own = normals;
  for (const int t : needles) normals.row(t).setZero();
  for (std::size_t before = 0; !needles.empty() && needles.size() != before;) {
    before = needles.size();
    Points sums = Points::Zero(normals.rows(), 3);
    for_each_edge_sum(edges, normals, [&](int slot, const Eigen::RowVector3d& sum) { sums.row(slot / 3) += sum; });
    for (const int t : needles) normals.row(t) = direction_of(sums.row(t));
    needles.erase(std::remove_if(needles.begin(), needles.end(), [&](int t) { return !normals.row(t).isZero(0); }),
                  needles.end());
  }
  for (const int t : needles) normals.row(t) = own.row(t);
}

void find_triangle_normals(const std::vector<HalfEdge>& edges, RestSurface& surface) {
  surface.triangle_normals.resize(surface.triangles.rows(), 3);
  std::vector<int> needles;
  for (int t = 0; t < int(surface.triangles.rows()); ++t) {
    const Vector3d ab = corner_of(surface, t, 1) - corner_of(surface, t, 0),
                   ac = corner_of(surface, t, 2) - corner_of(surface, t, 0), cross = ab.cross(ac);
    surface.triangle_normals.row(t) = cross.normalized().transpose();
    if (cross.norm() <= needle * std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()}))
      needles.push_back(t);
  }
  if (!needles.empty()) mend_needles(edges, std::move(needles), surface.triangle_normals);
}

void find_normals(RestSurface& surface) {
  const Eigen::Index count = surface.triangles.rows();
  const std::vector<HalfEdge> edges = sorted_edges(surface);
  find_triangle_normals(edges, surface);
  surface.edge_normals.resize(3 * count, 3);
  for_each_edge_sum(edges, surface.triangle_normals, [&](int slot, const Eigen::RowVector3d& sum) {
    surface.edge_normals.row(slot) = direction_of(sum);
  });
  surface.vertex_normals.setZero(surface.vertices.rows(), 3);
  for (int t = 0; t < int(count); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vector3d corner = corner_of(surface, t, k), next = corner_of(surface, t, (k + 1) % 3) - corner,
                     last = corner_of(surface, t, (k + 2) % 3) - corner;
      const double angle = std::atan2(next.cross(last).norm(), next.dot(last));
      surface.vertex_normals.row(surface.triangles(t, k)) += angle * surface.triangle_normals.row(t);
    }
  for (auto normal : surface.vertex_normals.rowwise()) normal = direction_of(normal);
}

Eigen::AlignedBox3d box_of(const RestSurface& surface, int begin, int end) {
  Eigen::AlignedBox3d box;
  for (int i = begin; i < end; ++i)
    for (int k = 0; k < 3; ++k) box.extend(corner_of(surface, surface.order[i], k));
  return box;
}

void set_box(const Eigen::AlignedBox3d& box, int child, RestSurface::Node& node) {
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis][child] = box.min()[axis];
    node.high[axis][child] = box.max()[axis];
  }
}

// Puts those of the triangles with lesser centres, along the longest axis, before the others; where these begin.
int halve(const Points& centres, int begin, int end, std::vector<int>& order) {
  Eigen::AlignedBox3d of_centres;
  for (int i = begin; i < end; ++i) of_centres.extend(centres.row(order[i]).transpose());
  Eigen::Index axis = 0;
  of_centres.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end, [&](int a, int b) {
    return centres(a, axis) != centres(b, axis) ? centres(a, axis) < centres(b, axis) : a < b;
  });
  return middle;
}

// The node's children are the halves of the two halves of the triangles in `order`, as far as they are large.
void split(const Points& centres, int at, int begin, int end, RestSurface& surface) {
  std::vector<int> bounds{begin, end};
  for (int round = 0; round < 2; ++round)
    for (std::size_t i = bounds.size() - 1; i-- > 0;)
      if (bounds[i + 1] - bounds[i] > leaf_size)
        bounds.insert(bounds.begin() + std::ptrdiff_t(i) + 1, halve(centres, bounds[i], bounds[i + 1], surface.order));
  RestSurface::Node node;
  for (int child = 0; child < 4; ++child) {
    const bool is_there = child + 1 < int(bounds.size());
    const int first = is_there ? bounds[child] : 0, count = is_there ? bounds[child + 1] - first : -1;
    set_box(is_there ? box_of(surface, first, first + count) : Eigen::AlignedBox3d(), child, node);
    node.first[child] = first;
    node.count[child] = count;
    if (count <= leaf_size) continue;
    node.first[child] = int(surface.nodes.size());
    node.count[child] = 0;
    surface.nodes.emplace_back();
  }
  surface.nodes[at] = node;
  for (int child = 0; child + 1 < int(bounds.size()); ++child)
    if (node.count[child] == 0) split(centres, node.first[child], bounds[child], bounds[child + 1], surface);
}

void build_tree(RestSurface& surface) {
  const Eigen::Index count = surface.triangles.rows();
  if (count == 0) return;
  Points centres(count, 3);
  for (int t = 0; t < int(count); ++t)
    centres.row(t) = (corner_of(surface, t, 0) + corner_of(surface, t, 1) + corner_of(surface, t, 2)).transpose() / 3;
  surface.order.resize(std::size_t(count));
  std::iota(surface.order.begin(), surface.order.end(), 0);
  surface.box = box_of(surface, 0, int(count));
  surface.nodes.reserve(std::size_t(count / 4 + 1));  // about
  surface.nodes.resize(1);
  split(centres, 0, 0, int(count), surface);
}

void line_up_corners(RestSurface& surface) {
  surface.corners.clear();
  surface.corners.reserve(surface.order.size());
  for (const int t : surface.order)
    surface.corners.push_back({corner_of(surface, t, 0), corner_of(surface, t, 1), corner_of(surface, t, 2)});
}

void prepare_cache(RestSurface& surface) {
  if (surface.nodes.empty()) return;
  const Eigen::AlignedBox3d& box = surface.box;
  DistanceCache& cache = surface.cache;
  cache.spacing = std::max(box.sizes().maxCoeff() / cache_intervals, std::numeric_limits<double>::min());
  cache.origin = box.min() - Vector3d::Constant(cache.spacing);
  for (int axis = 0; axis < 3; ++axis) cache.size[axis] = int(std::ceil(box.sizes()[axis] / cache.spacing)) + 3;
  const std::size_t count = std::size_t(cache.size[0]) * cache.size[1] * cache.size[2];
  cache.values = std::make_unique<std::atomic<float>[]>(count);
  for (std::size_t i = 0; i < count; ++i)
    cache.values[i].store(std::numeric_limits<float>::quiet_NaN(), std::memory_order_relaxed);
}

void refit_tree(RestSurface& surface) {
  std::vector<Eigen::AlignedBox3d> boxes(surface.nodes.size());
  for (std::size_t i = surface.nodes.size(); i-- > 0;) {
    RestSurface::Node& node = surface.nodes[i];
    for (int child = 0; child < 4; ++child) {
      const int first = node.first[child], count = node.count[child];
      if (count < 0) continue;
      const Eigen::AlignedBox3d box = count == 0 ? boxes[first] : box_of(surface, first, first + count);
      set_box(box, child, node);
      boxes[i].extend(box);
    }
  }
  if (!boxes.empty()) surface.box = boxes.front();
}

// Both at once: neither reads what the other writes.
void side_by_side(const std::function<void()>& first, const std::function<void()>& second) {
  parallel_blocks(2, 1, [&](Eigen::Index i, Eigen::Index) { i == 0 ? first() : second(); });
}

}  // namespace

RestSurface make_rest_surface(const Points& vertices, const Triangles& triangles) {
  RestSurface surface;
  weld(vertices, triangles, surface);
  side_by_side([&] { find_normals(surface); },
               [&] {
                 build_tree(surface);
                 line_up_corners(surface);
                 prepare_cache(surface);
               });
  return surface;
}

RestSurface moved_surface(const RestSurface& surface, const Points& vertices) {
  RestSurface moved;
  moved.vertices = vertices;
  moved.triangles = surface.triangles;
  moved.nodes = surface.nodes;
  moved.order = surface.order;
  side_by_side([&] { find_normals(moved); },
               [&] {
                 refit_tree(moved);
                 line_up_corners(moved);
               });
  return moved;
}

}  // namespace umax
