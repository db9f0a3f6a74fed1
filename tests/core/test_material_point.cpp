// A hex's material at a point of space, and bounds of where there is some.
#include "core/contact/material_point.h"

#include <Eigen/SVD>
#include <algorithm>

#include "core/element/rotation.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

Vector3d random_point(Random& random, double reach) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

Matrix3d random_matrix(Random& random) {
  Matrix3d matrix;
  for (int column = 0; column < 3; ++column) matrix.col(column) = random_point(random, 1);
  return matrix;
}

// of samples of the hex's surface [m], a little more than the least
double distance_of_samples(const Matrix8x3d& nodes, const Vector3d& point) {
  constexpr int parts = 12;
  double least = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i <= parts; ++i)
        for (int j = 0; j <= parts; ++j) {
          Vector3d s;
          s[axis] = side;
          s[(axis + 1) % 3] = 2.0 * i / parts - 1;
          s[(axis + 2) % 3] = 2.0 * j / parts - 1;
          least = std::min(least, (nodes.transpose() * shape_functions(s) - point).norm());
        }
  return least;
}

}  // namespace

TEST_CASE("the bound of a matrix's stretch is no less than its largest singular value, and that of a rotation is 1") {
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    const Matrix3d matrix = random_matrix(random);
    const double largest = Eigen::JacobiSVD<Matrix3d>(matrix).singularValues()[0];
    CHECK(stretch_bound(matrix) >= (1 - 1e-14) * largest);
    CHECK(stretch_bound(matrix) <= 1.74 * largest);
    CHECK(stretch_bound(3 * polar_rotation(matrix)) == Approx(3).epsilon(1e-12));
  }
}

TEST_CASE("what is known of how far a point is beyond a hex is never more than it is, and seldom nothing near it") {
  constexpr double cell = 0.1;
  Random random(5);
  Body body = touchable_block("b", {1, 1, 1}, {0, 0, 0}, cell);
  int known = 0, beyond = 0;
  double sharpest = 0;  // [-] of the distance
  for (int i = 0; i < 60; ++i) {
    const Model model = make_model({body}, {});
    Points positions = model.rest_positions;
    for (auto node : positions.rowwise()) node += random_point(random, 0.1 * cell).transpose();
    const HexBounds bounds = bound_hex(model, positions, 0);
    const Matrix8x3d nodes = hex_nodes(model, positions, 0);
    for (int k = 0; k < 40; ++k) {
      const Vector3d point = Vector3d::Constant(0.5 * cell) + random_point(random, 0.8 * cell);
      MaterialPoint material;
      const std::optional<Vector3d> s = find_local(bounds.maps, point);
      const double distance = s ? distance_beyond(bounds, *s) : 0;
      if (find_material(bounds.maps, point, within_hex, material)) {
        CHECK(distance == 0);
        continue;
      }
      const double sampled = distance_of_samples(nodes, point);
      CHECK(distance <= sampled);
      ++beyond;
      known += distance > 0;
      sharpest = std::max(sharpest, distance / sampled);
    }
  }
  CHECK(beyond > 1000);
  CHECK(2 * known > beyond);
  CHECK(sharpest > 0.5);
}

TEST_CASE("the bounds of a hex hold for all points in it") {
  Random random(5);
  const Body body = touchable_block("b", {1, 1, 1}, {0, 0, 0}, 0.1);
  const Model model = make_model({body}, {});
  for (int i = 0; i < 40; ++i) {
    Points positions = model.rest_positions;
    const Matrix3d turn = polar_rotation(random_matrix(random));
    for (auto node : positions.rowwise())
      node = (turn * node.transpose() + random_point(random, 0.015)).transpose().eval();
    const HexBounds bounds = bound_hex(model, positions, 0);
    REQUIRE(std::isfinite(bounds.rest_error));
    for (int k = 0; k < 40; ++k) {
      const Vector3d s = random_point(random, 1);
      const Vector3d point = hex_nodes(model, positions, 0).transpose() * shape_functions(s);
      MaterialPoint material;
      REQUIRE(find_material(bounds.maps, point, within_hex, material));
      const Vector3d from_centre = point - bounds.centre;
      CHECK((bounds.local_from_world * from_centre - s).cwiseAbs().maxCoeff() <= bounds.local_error + 1e-12);
      CHECK((bounds.rest_centre + bounds.rest_from_world * from_centre - material.rest).norm() <=
            bounds.rest_error + 1e-12);
      CHECK(Eigen::JacobiSVD<Matrix3d>(material.F_inverse).singularValues()[0] <= bounds.largest_inverse);
      CHECK(distance_from(bounds, point) == 0);
    }
  }
}
