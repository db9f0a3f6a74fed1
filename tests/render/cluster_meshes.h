// Meshes for the tests of triangles in clusters and of what moves.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "render/trace/traced_object.h"
#include "tests/support/render_shapes.h"

namespace umax::test {

/// The same random numbers everywhere.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  double operator()() { return double(random_()) / double(std::mt19937::max()) * 2 - 1; }  // -1 .. 1
  Vector3d vector() {
    const double x = (*this)(), y = (*this)(), z = (*this)();
    return {x, y, z};
  }

 private:
  std::mt19937 random_;
};

/// So many triangles, no two of which share a vertex.
inline TriangleMesh soup(int count, Numbers& number) {
  TriangleMesh mesh;
  mesh.positions.resize(3 * count, 3);
  mesh.triangles.resize(count, 3);
  for (int t = 0; t < count; ++t) {
    const Vector3d middle = 2 * number.vector();
    for (int c = 0; c < 3; ++c) {
      mesh.positions.row(3 * t + c) = (middle + number.vector()).transpose();
      mesh.triangles(t, c) = 3 * t + c;
    }
  }
  return mesh;
}

/// An open sheet in waves.
inline TriangleMesh sheet(int cells) {
  TriangleMesh mesh;
  mesh.positions.resize((cells + 1) * (cells + 1), 3);
  mesh.triangles.resize(2 * cells * cells, 3);
  const auto node = [&](int i, int j) { return i * (cells + 1) + j; };
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const double x = 4.0 * i / cells - 2, y = 4.0 * j / cells - 2;
      mesh.positions.row(node(i, j)) << x, y, 0.3 * std::sin(3 * x) * std::cos(2 * y);
    }
  for (int i = 0, t = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      mesh.triangles.row(t++) << node(i, j), node(i + 1, j), node(i + 1, j + 1);
      mesh.triangles.row(t++) << node(i, j), node(i + 1, j + 1), node(i, j + 1);
    }
  return mesh;
}

/// Long thin triangles around a point, in a plane aslant.
inline TriangleMesh fan(int count) {
  TriangleMesh mesh;
  mesh.positions.resize(count + 1, 3);
  mesh.triangles.resize(count, 3);
  mesh.positions.row(0).setZero();
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    mesh.positions.row(1 + i) << std::cos(angle), std::sin(angle), 0.5 * std::cos(angle);
    mesh.triangles.row(i) << 0, 1 + i, 1 + (i + 1) % count;
  }
  return mesh;
}

inline TracedObject traced(const TriangleMesh& mesh) {
  return make_traced_object(render_object(mesh));
}

}  // namespace umax::test
