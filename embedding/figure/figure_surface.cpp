#include "embedding/figure/figure_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace umax {
namespace {

Vector3d gradient(const DistanceFunction& distance, const Vector3d& p, double width, double reach) {
  // differences along the four diagonals of a cube: one evaluation fewer than central differences need twice
  static const Vector3d directions[4] = {{1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, 1, 1}};
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& direction : directions) sum += direction * distance(p + width * direction, reach);
  return sum / (4 * width);
}

/// For every vertex, the vertices that follow it in its triangles: in a closed surface, each neighbour once.
struct Rings {
  std::vector<int> begin, next, after;  // of vertex v: next[begin[v]] .. and, in the same triangle, the vertex after it
};

Rings make_rings(const TriangleMesh& mesh) {
  Rings rings;
  rings.begin.assign(std::size_t(mesh.num_vertices()) + 1, 0);
  for (const int v : mesh.triangles.reshaped()) ++rings.begin[v + 1];
  for (std::size_t v = 1; v < rings.begin.size(); ++v) rings.begin[v] += rings.begin[v - 1];
  rings.next.resize(rings.begin.back());
  rings.after.resize(rings.begin.back());
  std::vector<int> filled(rings.begin.begin(), rings.begin.end() - 1);
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int at = filled[mesh.triangles(t, k)]++;
      rings.next[at] = mesh.triangles(t, (k + 1) % 3);
      rings.after[at] = mesh.triangles(t, (k + 2) % 3);
    }
  }
  return rings;
}

/// Signed step [m] along a unit normal to the level set, at most half a cell.
double step_to_surface(const DistanceFunction& distance, double cell_size, const Vector3d& p, double steepness) {
  return std::clamp(-distance(p, 4 * cell_size) / steepness, -0.5 * cell_size, 0.5 * cell_size);
}

/// Moves every vertex towards the mean of its neighbours within the surface, then back onto the level set.
void relax(const DistanceFunction& distance, double cell_size, int rounds, TriangleMesh& mesh) {
  const Rings rings = make_rings(mesh);
  for (int round = 0; round < rounds; ++round) {
    const Points before = mesh.positions;
    tbb::parallel_for(Eigen::Index(0), mesh.num_vertices(), [&](Eigen::Index v) {
      const auto at = [&](int u) { return Vector3d(before.row(u).transpose()); };
      const Vector3d here = at(int(v));
      Vector3d mean = Vector3d::Zero(), normal = Vector3d::Zero();
      for (int i = rings.begin[v]; i < rings.begin[v + 1]; ++i) {
        mean += at(rings.next[i]);
        normal += (at(rings.next[i]) - here).cross(at(rings.after[i]) - here);
      }
      normal.normalize();
      const Vector3d move = mean / (rings.begin[v + 1] - rings.begin[v]) - here;
      const Vector3d slid = here + 0.6 * (move - move.dot(normal) * normal);
      mesh.positions.row(v) = (slid + step_to_surface(distance, cell_size, slid, 1) * normal).transpose();
    });
  }
}

/// A last Newton step onto the level set, and its unit normals.
void settle(const DistanceFunction& distance, double cell_size, TriangleMesh& mesh) {
  mesh.normals.resize(mesh.num_vertices(), 3);
  tbb::parallel_for(Eigen::Index(0), mesh.num_vertices(), [&](Eigen::Index v) {
    const Vector3d p = mesh.positions.row(v).transpose();
    const Vector3d slope = gradient(distance, p, 0.25 * cell_size, 4 * cell_size);
    const Vector3d normal = slope.normalized();
    const double steepness = std::max(slope.norm(), 0.5);
    mesh.positions.row(v) += (step_to_surface(distance, cell_size, p, steepness) * normal).transpose();
    mesh.normals.row(v) = normal.transpose();
  });
}

/// Triangles that fill a triangle's outline with midpoints on some edges: three corners cut off, or a fan from a
/// midpoint.
void cut(const std::vector<int>& outline, int num_old, std::vector<Eigen::RowVector3i>& triangles) {
  const int size = int(outline.size());
  const auto at = [&](int i) { return outline[i % size]; };
  if (size == 6) {
    for (const int i : {1, 3, 5}) triangles.emplace_back(at(i), at(i + 1), at(i + 2));
    triangles.emplace_back(at(1), at(3), at(5));
    return;
  }
  int first = 0;
  while (size > 3 && at(first) < num_old) ++first;
  for (int i = 1; i + 1 < size; ++i) triangles.emplace_back(at(first), at(first + i), at(first + i + 1));
}

/// Halves the edges of the triangles that `fine` asks for; neighbours are cut so that the surface stays closed.
void refine(const std::function<bool(const Vector3d&)>& fine, TriangleMesh& mesh) {
  using Edge = std::pair<int, int>;
  const auto edge = [&](Eigen::Index t, int k) {
    return Edge(std::minmax(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)));
  };
  std::vector<Edge> halved;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Eigen::RowVector3d middle = mesh.positions(mesh.triangles.row(t), Eigen::all).colwise().mean();
    if (!fine(middle.transpose())) continue;
    for (int k = 0; k < 3; ++k) halved.push_back(edge(t, k));
  }
  std::sort(halved.begin(), halved.end());
  halved.erase(std::unique(halved.begin(), halved.end()), halved.end());

  // one new vertex in the middle of each halved edge, in the order of the edges
  const Eigen::Index num_old = mesh.num_vertices();
  mesh.positions.conservativeResize(num_old + Eigen::Index(halved.size()), Eigen::NoChange);
  for (std::size_t i = 0; i < halved.size(); ++i) {
    mesh.positions.row(num_old + Eigen::Index(i)) =
        0.5 * (mesh.positions.row(halved[i].first) + mesh.positions.row(halved[i].second));
  }
  const auto midpoint = [&](const Edge& e) {
    const auto found = std::lower_bound(halved.begin(), halved.end(), e);
    return found != halved.end() && *found == e ? int(num_old + (found - halved.begin())) : -1;
  };

  // cut corners off at their two midpoints, and what is left at a single one
  std::vector<Eigen::RowVector3i> triangles;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    std::vector<int> outline;  // corners and midpoints in turn
    for (int k = 0; k < 3; ++k) {
      outline.push_back(mesh.triangles(t, k));
      const int middle = midpoint(edge(t, k));
      if (middle >= 0) outline.push_back(middle);
    }
    cut(outline, int(num_old), triangles);
  }
  mesh.triangles.resize(Eigen::Index(triangles.size()), 3);
  for (std::size_t i = 0; i < triangles.size(); ++i) mesh.triangles.row(Eigen::Index(i)) = triangles[i];
}

}  // namespace

TriangleMesh level_set_surface(const DistanceFunction& distance, const SurfaceOptions& options) {
  TriangleMesh mesh = contour(distance, options.min, options.max, options.cell_size);
  relax(distance, options.cell_size, options.relaxations, mesh);
  if (options.fine) {
    refine(options.fine, mesh);
    relax(distance, options.cell_size, options.relaxations, mesh);
  }
  settle(distance, options.cell_size, mesh);
  return mesh;
}

}  // namespace umax
