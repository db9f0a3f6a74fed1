// A small procedural scene for picture tests: sphere, torus and block on a ground plane, an area light and a sky.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "render/scene/render_scene.h"

namespace umax::test {

/// Surface of revolution or similar: a grid of (num_u x num_v) quads of point(u, v), u and v in [0, 1]; normals by
/// differences, so point() must be smooth. Counter-clockwise from the side of d/du x d/dv.
template <class Surface>
TriangleMesh make_grid(int num_u, int num_v, const Surface& point) {
  TriangleMesh mesh;
  mesh.positions.resize((num_u + 1) * (num_v + 1), 3);
  mesh.normals.resize(mesh.positions.rows(), 3);
  mesh.triangles.resize(2 * num_u * num_v, 3);
  constexpr double h = 1e-4;
  for (int i = 0; i <= num_u; ++i) {
    for (int j = 0; j <= num_v; ++j) {
      const double u = double(i) / num_u, v = std::clamp(double(j) / num_v, 10 * h, 1 - 10 * h);
      const Vector3d du = point(u + h, v) - point(u - h, v), dv = point(u, v + h) - point(u, v - h);
      mesh.positions.row(i * (num_v + 1) + j) = point(u, double(j) / num_v);
      mesh.normals.row(i * (num_v + 1) + j) = du.cross(dv).normalized();
    }
  }
  for (int i = 0; i < num_u; ++i) {
    for (int j = 0; j < num_v; ++j) {
      const int a = i * (num_v + 1) + j, b = a + num_v + 1, t = 2 * (i * num_v + j);
      mesh.triangles.row(t) << a, b, b + 1;
      mesh.triangles.row(t + 1) << a, b + 1, a + 1;
    }
  }
  return mesh;
}

inline TriangleMesh make_ball(const Vector3d& center, double radius) {
  constexpr double pi = std::numbers::pi;
  return make_grid(48, 24, [&](double u, double v) {
    const double azimuth = 2 * pi * u, polar = pi * (1 - v);
    return Vector3d(center + radius * Vector3d(std::sin(polar) * std::sin(azimuth), std::cos(polar),
                                               std::sin(polar) * std::cos(azimuth)));
  });
}

/// Lies flat, axis up.
inline TriangleMesh make_torus(const Vector3d& center, double radius, double tube) {
  constexpr double pi = std::numbers::pi;
  return make_grid(64, 24, [&](double u, double v) {
    const double around = 2 * pi * u, across = 2 * pi * v, r = radius + tube * std::cos(across);
    return Vector3d(center + Vector3d(r * std::sin(around), tube * std::sin(across), r * std::cos(around)));
  });
}

/// Flat faces, no normals.
inline TriangleMesh make_block(const Vector3d& center, const Vector3d& size) {
  TriangleMesh mesh;
  mesh.positions.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    mesh.positions.row(i) =
        (center + size.cwiseProduct(Vector3d(i & 1, i >> 1 & 1, i >> 2) - Vector3d(0.5, 0.5, 0.5))).transpose();
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5,
      3, 7, 5;
  return mesh;
}

/// A block around the origin that is wide and thin; its large faces look along z.
inline TriangleMesh slab(double half, double thickness) {
  return make_block({0, 0, 0}, {2 * half, 2 * half, thickness});
}

/// Square in the plane y = height, seen from above.
inline TriangleMesh make_floor(double half_size, double height = 0) {
  TriangleMesh mesh;
  mesh.positions.resize(4, 3);
  const double s = half_size, y = height;
  mesh.positions << -s, y, -s, -s, y, s, s, y, s, s, y, -s;
  mesh.normals = Vector3d(0, 1, 0).transpose().replicate(4, 1);
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3;
  return mesh;
}

inline RenderObject make_object(const char* name, TriangleMesh mesh, const Look& look) {
  return {name, std::make_shared<const TriangleMesh>(std::move(mesh)), look};
}

/// Square area light of the given edge [m] at `position`, facing `target`; power as Blender's area light [W].
inline AreaLight make_square_light(const Vector3f& position, const Vector3f& target, float edge, float power) {
  const Vector3f towards = (target - position).normalized();
  const Vector3f u = Vector3f(0, 1, 0).cross(towards).normalized(), v = towards.cross(u);
  AreaLight light;
  light.corner = position - 0.5f * edge * (u + v);
  light.edge_u = edge * u;
  light.edge_v = edge * v;
  light.radiance = Vector3f::Constant(power / (std::numbers::pi_v<float> * edge * edge));
  return light;
}

/// Glossy ball, clear-coated torus and matt block on a plane, under a softbox and a pale sky.
inline RenderScene make_still_life() {
  RenderScene scene;
  scene.objects.push_back(
      make_object("floor", make_floor(40), {.base_color = {0.42f, 0.42f, 0.43f}, .roughness = 0.6f}));
  scene.objects.push_back(
      make_object("ball", make_ball({-0.75, 0.6, 0.1}, 0.6), {.base_color = {0.62f, 0.09f, 0.06f}, .roughness = 0.3f}));
  scene.objects.push_back(make_object(
      "torus", make_torus({0.35, 0.18, 0.75}, 0.42, 0.18),
      {.base_color = {0.03f, 0.16f, 0.40f}, .roughness = 0.55f, .clearcoat = 1, .clearcoat_roughness = 0.08f}));
  scene.objects.push_back(make_object("block", make_block({0.75, 0.55, -0.55}, {0.7, 1.1, 0.7}),
                                      {.base_color = {0.75f, 0.55f, 0.22f}, .roughness = 0.7f}));
  scene.lights.push_back(make_square_light({2.5f, 4.0f, 2.5f}, {0, 0.5f, 0}, 1.6f, 260));
  scene.sky = GradientSky{{0.42f, 0.45f, 0.50f}, {0.14f, 0.19f, 0.30f}, {0.2f, 0.2f, 0.2f}};
  scene.camera = {.position = {0.4f, 1.7f, 4.6f}, .target = {0, 0.5f, 0}, .vertical_fov_degrees = 32};
  return scene;
}

}  // namespace umax::test
