// Small meshes and scenes for the tests of pictures.
#pragma once

#include <cmath>
#include <map>
#include <memory>

#include "render/scene/render_scene.h"

namespace umax::test {

/// Octahedron refined `levels` times onto the unit sphere, with smooth normals.
inline TriangleMesh unit_sphere(int levels) {
  std::vector<Vector3d> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<Vector3i> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                  {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [entry, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)}, int(points.size()));
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return entry->second;
    };
    std::vector<Vector3i> finer;
    for (const Vector3i& t : triangles) {
      const int ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  TriangleMesh mesh;
  mesh.positions.resize(Eigen::Index(points.size()), 3);
  mesh.triangles.resize(Eigen::Index(triangles.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.positions.row(Eigen::Index(i)) = points[i].transpose();
  for (std::size_t i = 0; i < triangles.size(); ++i) mesh.triangles.row(Eigen::Index(i)) = triangles[i].transpose();
  mesh.normals = mesh.positions;
  return mesh;
}

/// Horizontal square of half edge `half` at height y, facing up.
inline TriangleMesh floor_square(double half, double y = 0) {
  TriangleMesh mesh;
  mesh.positions.resize(4, 3);
  mesh.positions << -half, y, half, half, y, half, half, y, -half, -half, y, -half;
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3;
  return mesh;
}

inline RenderObject render_object(TriangleMesh mesh, const Look& look = {}) {
  return {.name = "test", .mesh = std::make_shared<const TriangleMesh>(std::move(mesh)), .look = look};
}

inline TriangleMesh moved(TriangleMesh mesh, const Vector3d& by, double scale = 1) {
  mesh.positions = (scale * mesh.positions).rowwise() + by.transpose();
  return mesh;
}

/// A sphere on a floor under a square light and a dim sky.
inline RenderScene sphere_on_floor() {
  RenderScene scene;
  scene.objects.push_back(
      render_object(moved(unit_sphere(4), {0, 1, 0}), {.base_color = {0.7f, 0.3f, 0.2f}, .roughness = 0.3f}));
  scene.objects.push_back(render_object(floor_square(20), {.roughness = 0.8f}));
  scene.lights.push_back({.corner = {1, 4, 1}, .edge_u = {1, 0, 0}, .edge_v = {0, 0, 1}, .radiance = {30, 30, 30}});
  return scene;
}

}  // namespace umax::test
