// Hexahedra to test with: boxes, distorted ones, random deformations that are the same on every machine.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "core/hexahedron.h"

namespace umax::test {

/// Reproducible numbers, independent of the standard library's distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 2654435769u + 1) {}
  double uniform(double low, double high) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double(state_ >> 11) * 0x1p-53);
  }
  Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Matrix3d matrix(double size) {
    Matrix3d m;
    for (int i = 0; i < 3; ++i) m.row(i) = vector(size);
    return m;
  }
  Matrix8x3d nodes(double size) {
    Matrix8x3d m;
    for (int j = 0; j < 8; ++j) m.row(j) = vector(size);
    return m;
  }
  Matrix3d rotation() {
    Eigen::Quaterniond q(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    return q.normalized().toRotationMatrix();
  }

 private:
  std::uint64_t state_;
};

inline Matrix8x3d box_nodes(const Vector3d& size) {
  Matrix8x3d nodes;
  for (int n = 0; n < 8; ++n) nodes.row(n) << size[0] * (n >> 2 & 1), size[1] * (n >> 1 & 1), size[2] * (n & 1);
  return nodes;
}

/// About a unit cube, no two edges parallel.
inline Matrix8x3d distorted_nodes() {
  return box_nodes({1.0, 0.8, 1.1}) + Random(5).nodes(0.12);
}

/// x_j = A X_j + t
inline Matrix8x3d affine(const Matrix8x3d& nodes, const Matrix3d& A, const Vector3d& t = Vector3d::Zero()) {
  return (nodes * A.transpose()).rowwise() + t.transpose();
}

/// Rotated, moved, and every node displaced by up to noise [m].
inline Matrix8x3d deformed(const Matrix8x3d& nodes, Random& random, double noise) {
  return affine(nodes + random.nodes(noise), random.rotation(), random.vector(2));
}

inline Vector24d stacked(const Matrix8x3d& nodes) {
  return Eigen::Map<const Vector24d>(nodes.data());
}
inline Matrix8x3d as_nodes(const Vector24d& v) {
  return Eigen::Map<const Matrix8x3d>(v.data());
}

/// Sum of x_j x f_j.
inline Vector3d torque(const Matrix8x3d& x, const Vector24d& f) {
  Vector3d sum = Vector3d::Zero();
  for (int j = 0; j < 8; ++j) sum += Vector3d(x.row(j)).cross(f.segment<3>(3 * j));
  return sum;
}

inline const std::array<RotationEstimate, num_rotation_estimates> rotation_estimates = {
    RotationEstimate::centre, RotationEstimate::tetrahedron, RotationEstimate::kuhn};

}  // namespace umax::test
