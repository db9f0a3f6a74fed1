#include "tests/support/hex_samples.h"

#include <Eigen/Geometry>

namespace umax::test {

Matrix3d Random::matrix(double size) {
  Matrix3d m;
  for (int i = 0; i < 3; ++i) m.row(i) = vector(size);
  return m;
}

Matrix8x3d Random::nodes(double size) {
  Matrix8x3d m;
  for (int j = 0; j < 8; ++j) m.row(j) = vector(size);
  return m;
}

Matrix3d Random::rotation() {
  Eigen::Quaterniond q(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
  return q.normalized().toRotationMatrix();
}

Matrix8x3d box_nodes(const Vector3d& size) {
  Matrix8x3d nodes;
  for (int n = 0; n < 8; ++n) nodes.row(n) << size[0] * (n >> 2 & 1), size[1] * (n >> 1 & 1), size[2] * (n & 1);
  return nodes;
}

Matrix8x3d distorted_nodes() {
  return box_nodes({1.0, 0.8, 1.1}) + Random(5).nodes(0.12);
}

Matrix8x3d affine(const Matrix8x3d& nodes, const Matrix3d& A, const Vector3d& t) {
  return (nodes * A.transpose()).rowwise() + t.transpose();
}

Matrix8x3d deformed(const Matrix8x3d& nodes, Random& random, double noise) {
  return affine(nodes + random.nodes(noise), random.rotation(), random.vector(2));
}

Vector24d stacked(const Matrix8x3d& nodes) {
  return Eigen::Map<const Vector24d>(nodes.data());
}

Matrix8x3d as_nodes(const Vector24d& v) {
  return Eigen::Map<const Matrix8x3d>(v.data());
}

Vector3d torque(const Matrix8x3d& x, const Vector24d& f) {
  Vector3d sum = Vector3d::Zero();
  for (int j = 0; j < 8; ++j) sum += Vector3d(x.row(j)).cross(f.segment<3>(3 * j));
  return sum;
}

}  // namespace umax::test
