// Hexahedra to test with: boxes, distorted ones, random deformations that are the same on every machine.
#pragma once

#include <cstdint>

#include "core/element/hexahedron.h"

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
  Matrix3d matrix(double size);
  Matrix8x3d nodes(double size);
  Matrix3d rotation();

 private:
  std::uint64_t state_;
};

Matrix8x3d box_nodes(const Vector3d& size);

/// About a unit cube, no two edges parallel.
Matrix8x3d distorted_nodes();

/// x_j = A X_j + t
Matrix8x3d affine(const Matrix8x3d& nodes, const Matrix3d& A, const Vector3d& t = Vector3d::Zero());

/// Rotated, moved, and every node displaced by up to noise [m].
Matrix8x3d deformed(const Matrix8x3d& nodes, Random& random, double noise);

Vector24d stacked(const Matrix8x3d& nodes);
Matrix8x3d as_nodes(const Vector24d& v);

/// Sum of x_j x f_j.
Vector3d torque(const Matrix8x3d& x, const Vector24d& f);

inline const std::array<RotationEstimate, num_rotation_estimates> rotation_estimates = {
    RotationEstimate::centre, RotationEstimate::tetrahedron, RotationEstimate::kuhn};

}  // namespace umax::test
