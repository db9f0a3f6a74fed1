// What is asked of a rest surface: nearest points, bounds of distances, crossings.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/model/rest_surface.h"

namespace umax {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double on_surface = 1e-9;      // [box diagonals] nearer points have the surface's own normal
constexpr double on_edge = 1e-9;         // [-] of barycentric coordinates, by which crossings at edges count
constexpr int stack_size = 128;          // nodes of 31 levels and the children beside them
constexpr double cache_rounding = 1e-6;  // [-] of a float, and of places in the grid

enum class Feature { face, edge0, edge1, edge2, corner0, corner1, corner2 };

struct TrianglePoint {
  Vector3d point;
  Feature feature = Feature::face;
};

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

// the nearest triangle of those that `counts` lets count, with the place on it
struct Nearest {
  int triangle = -1;
  double squared = 0;
  TrianglePoint place{Vector3d::Zero()};
};

// A child of a node that is to be looked at; squared: of its box's distance [m^2].
struct Entry {
  int first = 0, count = 0;
  double squared = 0;
};

// Puts children that are no farther than this onto the stack, the nearest one last; the stack's new size.
int push_children(const RestSurface::Node& node, const Vector3d& point, double farthest_squared, Entry* stack,
                  int size) {
  Eigen::Array4d squared = Eigen::Array4d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Array4d away = (node.low[axis] - point[axis]).max(point[axis] - node.high[axis]).max(0.0);
    squared += away * away;
  }
  const int before = size;
  for (int child = 0; child < 4; ++child) {
    if (node.count[child] < 0 || squared[child] > farthest_squared) continue;
    int place = size++;
    for (; place > before && stack[place - 1].squared < squared[child]; --place) stack[place] = stack[place - 1];
    stack[place] = {node.first[child], node.count[child], squared[child]};
  }
  return size;
}

template <class Counts>
Nearest find_nearest(const RestSurface& surface, const Vector3d& point, double reach, const Counts& counts) {
  Nearest nearest{.squared = reach * reach};
  if (surface.nodes.empty()) return nearest;
  Entry stack[stack_size];
  int size = push_children(surface.nodes[0], point, nearest.squared, stack, 0);
  while (size > 0) {
    const Entry at = stack[--size];
    if (at.squared > nearest.squared) continue;
    if (at.count == 0) {
      size = push_children(surface.nodes[at.first], point, nearest.squared, stack, size);
      continue;
    }
    for (int i = at.first; i < at.first + at.count; ++i) {
      const int t = surface.order[i];
      if (!counts(t)) continue;
      const auto& [a, b, c] = surface.corners[std::size_t(i)];
      const TrianglePoint place = nearest_of_triangle(a, b, c, point);
      const double squared = (point - place.point).squaredNorm();
      if (squared < nearest.squared || (squared == nearest.squared && (nearest.triangle < 0 || t < nearest.triangle)))
        nearest = {t, squared, place};
    }
  }
  return nearest;
}

// Calls visit(t) for each triangle of the leaves whose boxes meet this one.
template <class Visit>
void for_each_triangle(const RestSurface& surface, const Eigen::AlignedBox3d& box, const Visit& visit) {
  if (surface.nodes.empty()) return;
  int stack[stack_size], size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const RestSurface::Node& node = surface.nodes[stack[--size]];
    Eigen::Array4d apart = Eigen::Array4d::Constant(-infinity);  // positive: by this
    for (int axis = 0; axis < 3; ++axis)
      apart = apart.max(node.low[axis] - box.max()[axis]).max(box.min()[axis] - node.high[axis]);
    for (int child = 0; child < 4; ++child) {
      if (apart[child] > 0) continue;
      if (node.count[child] == 0) stack[size++] = node.first[child];
      for (int i = node.first[child]; i < node.first[child] + node.count[child]; ++i) visit(surface.order[i]);
    }
  }
}

// Do all triangles at the edge or corner that is nearest count?
template <class Counts>
bool all_count(const RestSurface& surface, const Nearest& nearest, const Counts& counts) {
  if (nearest.place.feature == Feature::face) return true;
  const bool is_corner = nearest.place.feature >= Feature::corner0;
  const int k = (int(nearest.place.feature) - 1) % 3;
  const auto corners = surface.triangles.row(nearest.triangle);
  const int first = corners[k], second = corners[is_corner ? k : (k + 1) % 3];
  const Vector3d place = surface.vertices.row(first).transpose();
  bool all = true;
  for_each_triangle(surface, Eigen::AlignedBox3d(place), [&](int t) {
    const auto of = surface.triangles.row(t).array();
    if ((of == first).any() && (of == second).any() && !counts(t)) all = false;
  });
  return all;
}

// the triangle's own normal where those at an edge or a corner sum to nothing
Vector3d pseudonormal(const RestSurface& surface, const Nearest& nearest) {
  const int feature = int(nearest.place.feature);
  Vector3d normal = Vector3d::Zero();
  if (feature > 3) normal = surface.vertex_normals.row(surface.triangles(nearest.triangle, feature - 4)).transpose();
  if (feature > 0 && feature <= 3) normal = surface.edge_normals.row(3 * nearest.triangle + feature - 1).transpose();
  return normal.isZero(0) ? Vector3d(surface.triangle_normals.row(nearest.triangle).transpose()) : normal;
}

SurfaceHit hit_at(const RestSurface& surface, const Vector3d& point, const Nearest& nearest, const Vector3d& normal) {
  const Vector3d away = point - nearest.place.point;
  const double distance = away.norm();
  const double sign = away.dot(normal) < 0 ? -1 : 1;
  const bool is_near = distance <= on_surface * surface.box.diagonal().norm();
  return {nearest.triangle, nearest.place.point, is_near ? normal : Vector3d(sign / distance * away), sign * distance};
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

// of the triangles that the segment enters, the one with the least share, or with sign -1 the largest
int entered_at_end(const RestSurface& surface, const Vector3d& from, const Vector3d& to, double sign) {
  constexpr double nothing = 1.5;
  double least = nothing;
  int found = -1;
  Eigen::AlignedBox3d path(from);
  path.extend(to);
  for_each_triangle(surface, path, [&](int t) {
    const double share = entry(surface, t, from, to);
    if (share >= nothing) return;
    if (sign * share < least || (sign * share == least && t < found)) least = sign * share, found = t;
  });
  return found;
}

// at a place in the units of the cache's grid
DistanceBounds bounds_at(const RestSurface& surface, const Vector3d& place) {
  const DistanceCache& cache = surface.cache;
  Vector3i at;
  for (int axis = 0; axis < 3; ++axis) at[axis] = int(std::clamp(place[axis] + 0.5, 0.0, double(cache.size[axis] - 1)));
  std::atomic<float>& value = cache.values[(std::size_t(at[0]) * cache.size[1] + at[1]) * cache.size[2] + at[2]];
  float distance = value.load(std::memory_order_relaxed);
  if (std::isnan(distance)) {
    distance = float(nearest_point(surface, cache.origin + cache.spacing * at.cast<double>(), infinity).distance);
    value.store(distance, std::memory_order_relaxed);
  }
  const double away = cache.spacing * (place - at.cast<double>()).norm() +
                      cache_rounding * (std::abs(double(distance)) + cache.spacing);
  return {double(distance) - away, double(distance) + away};
}

SurfaceHit scaled(SurfaceHit hit, double scale) {
  hit.point *= scale;
  hit.distance *= scale;
  return hit;
}

}  // namespace

SurfaceHit nearest_point(const RestSurface& surface, const Vector3d& point, double reach) {
  const Nearest nearest = find_nearest(surface, point, reach, [](int) { return true; });
  if (nearest.triangle < 0) return {};
  return hit_at(surface, point, nearest, pseudonormal(surface, nearest));
}

DistanceBounds distance_bounds(const RestSurface& surface, const Vector3d& point) {
  const DistanceCache& cache = surface.cache;
  if (!cache.values) return {infinity, infinity};
  return bounds_at(surface, (point - cache.origin) / cache.spacing);
}

DistanceView view_distances(const ScaledSurface& surface, const Matrix3d& linear, const Vector3d& translation) {
  const DistanceCache& cache = surface.of.cache;
  DistanceView view{&surface.of, surface.scale};
  if (!cache.values) return view;
  const double spacing = surface.scale * cache.spacing;
  view.grid_from_point = linear / spacing;
  view.grid_origin = (translation - surface.scale * cache.origin) / spacing;
  return view;
}

double least_distance(const DistanceView& view, const Vector3d& point) {
  if (!view.surface->cache.values) return infinity;
  return view.scale * bounds_at(*view.surface, view.grid_from_point * point + view.grid_origin).low;
}

SurfaceHit nearest_alike(const RestSurface& surface, const Vector3d& point, const Vector3d& direction, double cosine,
                         double reach) {
  const auto is_alike = [&](int t) { return surface.triangle_normals.row(t).dot(direction.transpose()) >= cosine; };
  const Nearest nearest = find_nearest(surface, point, reach, is_alike);
  if (nearest.triangle < 0) return {};
  if (all_count(surface, nearest, is_alike)) return hit_at(surface, point, nearest, pseudonormal(surface, nearest));
  return hit_at(surface, point, nearest, surface.triangle_normals.row(nearest.triangle).transpose());
}

int first_entered(const RestSurface& surface, const Vector3d& from, const Vector3d& to) {
  return entered_at_end(surface, from, to, 1);
}

int last_entered(const RestSurface& surface, const Vector3d& from, const Vector3d& to) {
  return entered_at_end(surface, from, to, -1);
}

SurfaceHit nearest_point(const ScaledSurface& surface, const Vector3d& point, double reach) {
  return scaled(nearest_point(surface.of, point / surface.scale, reach / surface.scale), surface.scale);
}

DistanceBounds distance_bounds(const ScaledSurface& surface, const Vector3d& point) {
  const DistanceBounds bounds = distance_bounds(surface.of, point / surface.scale);
  return {surface.scale * bounds.low, surface.scale * bounds.high};
}

SurfaceHit nearest_alike(const ScaledSurface& surface, const Vector3d& point, const Vector3d& direction, double cosine,
                         double reach) {
  return scaled(nearest_alike(surface.of, point / surface.scale, direction, cosine, reach / surface.scale),
                surface.scale);
}

int first_entered(const ScaledSurface& surface, const Vector3d& from, const Vector3d& to) {
  return first_entered(surface.of, from / surface.scale, to / surface.scale);
}

int last_entered(const ScaledSurface& surface, const Vector3d& from, const Vector3d& to) {
  return last_entered(surface.of, from / surface.scale, to / surface.scale);
}

}  // namespace umax
