// Small meshes and files for the tests of embedding/.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <string>

#include "embedding/cage/voxelize.h"
#include "embedding/surface/shapes.h"
#include "tests/support/temporary_folder.h"

namespace umax::testing {

/// Writes a file into the tests' output folder and returns its path.
inline std::filesystem::path write_file(const std::string& name, const std::string& content) {
  const std::filesystem::path path = output_folder() / name;
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

/// Both meshes in one.
inline TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh;
  mesh.positions.resize(a.num_vertices() + b.num_vertices(), 3);
  mesh.positions << a.positions, b.positions;
  mesh.triangles.resize(a.num_triangles() + b.num_triangles(), 3);
  mesh.triangles << a.triangles, (b.triangles.array() + int(a.num_vertices())).matrix();
  return mesh;
}

inline TriangleMesh moved(TriangleMesh mesh, const Vector3d& by) {
  mesh.positions.rowwise() += by.transpose();
  return mesh;
}

inline TriangleMesh turned_inside_out(TriangleMesh mesh) {
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

/// The triangles whose centroid satisfies keep(centroid).
template <class Keep>
TriangleMesh part_of(const TriangleMesh& mesh, Keep keep) {
  TriangleMesh part = mesh;
  Eigen::Index kept = 0;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    Vector3d centroid = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) centroid += mesh.positions.row(mesh.triangles(t, k)).transpose() / 3;
    if (keep(centroid)) part.triangles.row(kept++) = mesh.triangles.row(t);
  }
  part.triangles.conservativeResize(kept, 3);
  return part;
}

/// Sphere with bumps from a few random waves.
inline TriangleMesh blob(unsigned seed, int subdivisions = 4) {
  std::mt19937 random(seed);
  const auto number = [&](double low, double high) {
    return low + (high - low) * double(random()) / double(random.max());
  };
  TriangleMesh mesh = make_sphere(1, subdivisions);
  for (int wave = 0; wave < 5; ++wave) {
    const Vector3d direction(number(-5, 5), number(-5, 5), number(-5, 5));
    const double phase = number(0, 6), height = number(0.02, 0.12);
    for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v)
      mesh.positions.row(v) *= 1 + height * std::sin(direction.dot(mesh.positions.row(v)) + phase);
  }
  mesh.positions.col(0) *= number(0.5, 2);
  mesh.positions.col(2) *= number(0.3, 1);
  return moved(mesh, Vector3d(number(-9, 9), number(-9, 9), number(-9, 9)));
}

/// A closed cone of height and radius 1 on the plane y = 0: two fans of so many triangles.
inline TriangleMesh cone(int sides) {
  TriangleMesh mesh;
  mesh.positions.resize(sides + 2, 3);
  mesh.triangles.resize(2 * sides, 3);
  mesh.positions.row(0) << 0, 1, 0;
  mesh.positions.row(1) << 0, 0, 0;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.positions.row(2 + i) << std::cos(angle), 0, std::sin(angle);
    const int here = 2 + i, next = 2 + (i + 1) % sides;
    mesh.triangles.row(2 * i) << 0, next, here;
    mesh.triangles.row(2 * i + 1) << 1, here, next;
  }
  return mesh;
}

inline constexpr double unit_sphere_volume = 4.18879020478639;

}  // namespace umax::testing
