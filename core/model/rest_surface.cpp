#include "core/model/rest_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace umax {
namespace {

constexpr int leaf_size = 4;
constexpr double on_surface = 1e-9;  // [box diagonals] nearer points have the surface's own normal
constexpr double on_edge = 1e-9;     // [-] of barycentric coordinates, by which crossings at edges count
constexpr int max_depth = 64;
constexpr int cache_intervals = 128;     // of the cache, along the longest side
constexpr double cache_rounding = 1e-6;  // [-] of a float
constexpr float not_asked = std::numeric_limits<float>::quiet_NaN();

enum class Feature { face, edge0, edge1, edge2, corner0, corner1, corner2 };

struct TrianglePoint {
  Vector3d point;
  Feature feature = Feature::face;
};

Vector3d corner_of(const RestSurface& surface, int triangle, int k) {
  return surface.vertices.row(surface.triangles(triangle, k)).transpose();
}

// nearest point of a triangle, by the region that the point is in (Ericson 2005, Real-Time Collision Detection, 5.1.5)
TrianglePoint nearest_of_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return {a, Feature::corner0};
  if (d3 >= 0 && d4 <= d3) return {b, Feature::corner1};
  if (d6 >= 0 && d5 <= d6) return {c, Feature::corner2};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + d1 / (d1 - d3) * ab, Feature::edge0};
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + d2 / (d2 - d6) * ac, Feature::edge2};
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b), Feature::edge1};
  const double scale = 1 / (va + vb + vc);
  return {a + scale * vb * ab + scale * vc * ac, Feature::face};
}

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

void find_normals(RestSurface& surface) {
  const Eigen::Index count = surface.triangles.rows();
  surface.triangle_normals.resize(count, 3);
  surface.edge_normals.setZero(3 * count, 3);
  surface.vertex_normals.setZero(surface.vertices.rows(), 3);
  std::vector<HalfEdge> edges;
  edges.reserve(std::size_t(3 * count));
  for (int t = 0; t < int(count); ++t) {
    const std::array corners{corner_of(surface, t, 0), corner_of(surface, t, 1), corner_of(surface, t, 2)};
    const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    surface.triangle_normals.row(t) = normal.transpose();
    for (int k = 0; k < 3; ++k) {
      const Vector3d next = corners[(k + 1) % 3] - corners[k], last = corners[(k + 2) % 3] - corners[k];
      const double angle = std::atan2(next.cross(last).norm(), next.dot(last));
      surface.vertex_normals.row(surface.triangles(t, k)) += angle * normal.transpose();
      const auto [low, high] = std::minmax(surface.triangles(t, k), surface.triangles(t, (k + 1) % 3));
      edges.push_back({{low, high}, 3 * t + k});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.vertices != b.vertices ? a.vertices < b.vertices : a.slot < b.slot;
  });
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (end = begin; end < edges.size() && edges[end].vertices == edges[begin].vertices; ++end)
      sum += surface.triangle_normals.row(edges[end].slot / 3);
    for (std::size_t i = begin; i < end; ++i) surface.edge_normals.row(edges[i].slot) = sum;
  }
  surface.vertex_normals.rowwise().normalize();
  surface.edge_normals.rowwise().normalize();
}

void split(const RestSurface& surface, const Points& centres, int at, int begin, int end,
           std::vector<RestSurface::Node>& nodes, std::vector<int>& order) {
  Eigen::AlignedBox3d box, of_centres;
  for (int i = begin; i < end; ++i) {
    for (int k = 0; k < 3; ++k) box.extend(corner_of(surface, order[i], k));
    of_centres.extend(centres.row(order[i]).transpose());
  }
  nodes[at].box = box;
  if (end - begin <= leaf_size) {
    nodes[at].first = begin;
    nodes[at].count = end - begin;
    return;
  }
  Eigen::Index axis = 0;
  of_centres.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end, [&](int a, int b) {
    return centres(a, axis) != centres(b, axis) ? centres(a, axis) < centres(b, axis) : a < b;
  });
  const int first = int(nodes.size());
  nodes[at].first = first;
  nodes.resize(nodes.size() + 2);
  split(surface, centres, first, begin, middle, nodes, order);
  split(surface, centres, first + 1, middle, end, nodes, order);
}

void build_tree(RestSurface& surface) {
  const Eigen::Index count = surface.triangles.rows();
  if (count == 0) return;
  Points centres(count, 3);
  for (int t = 0; t < int(count); ++t)
    centres.row(t) = (corner_of(surface, t, 0) + corner_of(surface, t, 1) + corner_of(surface, t, 2)).transpose() / 3;
  surface.order.resize(std::size_t(count));
  std::iota(surface.order.begin(), surface.order.end(), 0);
  surface.nodes.reserve(std::size_t(count));
  surface.nodes.resize(1);
  split(surface, centres, 0, 0, int(count), surface.nodes, surface.order);
}

// the nearest triangle of those that `counts` lets count, with the place on it
struct Nearest {
  int triangle = -1;
  double squared = 0;
  TrianglePoint place{Vector3d::Zero()};
};

template <class Counts>
Nearest find_nearest(const RestSurface& surface, const Vector3d& point, double reach, const Counts& counts) {
  Nearest nearest{.squared = reach * reach};
  if (surface.nodes.empty()) return nearest;
  struct Entry {
    int node;
    double squared;
  } stack[max_depth];
  int size = 0;
  stack[size++] = {0, surface.nodes[0].box.squaredExteriorDistance(point)};
  while (size > 0) {
    const Entry at = stack[--size];
    if (at.squared > nearest.squared) continue;
    const RestSurface::Node& node = surface.nodes[at.node];
    if (node.count == 0) {
      const double left = surface.nodes[node.first].box.squaredExteriorDistance(point),
                   right = surface.nodes[node.first + 1].box.squaredExteriorDistance(point);
      const bool left_first = left <= right;
      stack[size++] = left_first ? Entry{node.first + 1, right} : Entry{node.first, left};
      stack[size++] = left_first ? Entry{node.first, left} : Entry{node.first + 1, right};
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int t = surface.order[i];
      if (!counts(t)) continue;
      const TrianglePoint place =
          nearest_of_triangle(corner_of(surface, t, 0), corner_of(surface, t, 1), corner_of(surface, t, 2), point);
      const double squared = (point - place.point).squaredNorm();
      if (squared < nearest.squared || (squared == nearest.squared && (nearest.triangle < 0 || t < nearest.triangle)))
        nearest = {t, squared, place};
    }
  }
  return nearest;
}

Vector3d pseudonormal(const RestSurface& surface, const Nearest& nearest) {
  const int feature = int(nearest.place.feature);
  if (feature == 0) return surface.triangle_normals.row(nearest.triangle).transpose();
  if (feature <= 3) return surface.edge_normals.row(3 * nearest.triangle + feature - 1).transpose();
  return surface.vertex_normals.row(surface.triangles(nearest.triangle, feature - 4)).transpose();
}

SurfaceHit hit_at(const RestSurface& surface, const Vector3d& point, const Nearest& nearest, const Vector3d& normal) {
  const Vector3d away = point - nearest.place.point;
  const double distance = away.norm();
  const double sign = away.dot(normal) < 0 ? -1 : 1;
  const bool is_near = distance <= on_surface * surface.nodes[0].box.diagonal().norm();
  return {nearest.triangle, nearest.place.point, is_near ? normal : Vector3d(sign / distance * away), sign * distance};
}

void prepare_cache(RestSurface& surface) {
  if (surface.nodes.empty()) return;
  const Eigen::AlignedBox3d& box = surface.nodes[0].box;
  DistanceCache& cache = surface.cache;
  cache.spacing = std::max(box.sizes().maxCoeff() / cache_intervals, std::numeric_limits<double>::min());
  cache.origin = box.min() - Vector3d::Constant(cache.spacing);
  for (int axis = 0; axis < 3; ++axis) cache.size[axis] = int(std::ceil(box.sizes()[axis] / cache.spacing)) + 3;
  const std::size_t count = std::size_t(cache.size[0]) * cache.size[1] * cache.size[2];
  cache.values = std::make_unique<std::atomic<float>[]>(count);
  for (std::size_t i = 0; i < count; ++i) cache.values[i].store(not_asked, std::memory_order_relaxed);
}

// the share of the segment at which it crosses the triangle from front to back; 2: nowhere
double entry(const RestSurface& surface, int t, const Vector3d& from, const Vector3d& to) {
  constexpr double nowhere = 2;
  const Vector3d n = surface.triangle_normals.row(t).transpose(), a = corner_of(surface, t, 0);
  const double before = n.dot(from - a), after = n.dot(to - a);
  if (before < 0 || after >= 0) return nowhere;
  const double share = before / (before - after);
  const Vector3d crossing = from + share * (to - from);
  for (int k = 0; k < 3; ++k) {
    const Vector3d corner = corner_of(surface, t, k), edge = corner_of(surface, t, (k + 1) % 3) - corner;
    if (n.dot(edge.cross(crossing - corner)) < -on_edge * edge.squaredNorm()) return nowhere;
  }
  return share;
}

}  // namespace

RestSurface make_rest_surface(const Points& vertices, const Triangles& triangles) {
  RestSurface surface;
  weld(vertices, triangles, surface);
  find_normals(surface);
  build_tree(surface);
  prepare_cache(surface);
  return surface;
}

SurfaceHit nearest_point(const RestSurface& surface, const Vector3d& point, double reach) {
  const Nearest nearest = find_nearest(surface, point, reach, [](int) { return true; });
  if (nearest.triangle < 0) return {};
  return hit_at(surface, point, nearest, pseudonormal(surface, nearest));
}

DistanceBounds distance_bounds(const RestSurface& surface, const Vector3d& point) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const DistanceCache& cache = surface.cache;
  if (!cache.values) return {infinity, infinity};
  Vector3i at;
  for (int axis = 0; axis < 3; ++axis)
    at[axis] = int(
        std::clamp(std::round((point[axis] - cache.origin[axis]) / cache.spacing), 0.0, double(cache.size[axis] - 1)));
  const Vector3d sample = cache.origin + cache.spacing * at.cast<double>();
  std::atomic<float>& value = cache.values[(std::size_t(at[0]) * cache.size[1] + at[1]) * cache.size[2] + at[2]];
  float distance = value.load(std::memory_order_relaxed);
  if (std::isnan(distance)) {
    distance = float(nearest_point(surface, sample, infinity).distance);
    value.store(distance, std::memory_order_relaxed);
  }
  const double away = (point - sample).norm() + cache_rounding * std::abs(double(distance));
  return {double(distance) - away, double(distance) + away};
}

SurfaceHit nearest_alike(const RestSurface& surface, const Vector3d& point, const Vector3d& direction, double cosine,
                         double reach) {
  const auto is_alike = [&](int t) { return surface.triangle_normals.row(t).dot(direction.transpose()) >= cosine; };
  const Nearest nearest = find_nearest(surface, point, reach, is_alike);
  if (nearest.triangle < 0) return {};
  return hit_at(surface, point, nearest, surface.triangle_normals.row(nearest.triangle).transpose());
}

int first_entered(const RestSurface& surface, const Vector3d& from, const Vector3d& to) {
  if (surface.nodes.empty()) return -1;
  double least = 1.5;
  int first = -1;
  Eigen::AlignedBox3d path(from);
  path.extend(to);
  int stack[max_depth], size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const RestSurface::Node& node = surface.nodes[stack[--size]];
    if (!node.box.intersects(path)) continue;
    if (node.count == 0) {
      stack[size++] = node.first;
      stack[size++] = node.first + 1;
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int t = surface.order[i];
      const double share = entry(surface, t, from, to);
      if (share < least || (share == least && t < first)) least = share, first = t;
    }
  }
  return first;
}

}  // namespace umax
