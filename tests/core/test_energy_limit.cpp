#include "core/element/energy_limit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/element/material.h"
#include "tests/support/catch.h"
#include "tests/support/finite_differences.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double young = 150e3, poisson = 0.3;
const Vector3d beam_cell(1.0 / 14, 0.06, 0.06);

// e_paper / e_true of a small symmetric strain
double energy_ratio(const HexShape& shape, const Matrix3d& strain) {
  const CorotatedHex hex =
      corotate(shape, RotationEstimate::centre, affine(shape.rest_nodes, Matrix3d::Identity() + strain));
  return elastic_energy(shape.stiffness_paper, young, hex) / elastic_energy(shape.stiffness, young, hex);
}

Matrix3d uniaxial(const Vector3d& direction) {
  const Vector3d d = direction.normalized();
  return 0.1 * (1 + poisson) * d * d.transpose() - 0.1 * poisson * Matrix3d::Identity();
}

}  // namespace

TEST_CASE("the limit is 1 at rest, 0 on the limit and negative beyond") {
  const HexShape shape = make_hex_shape(box_nodes(beam_cell), poisson);
  const double limit = density_from_stretch(young, 0.1) * shape.volume;
  const auto value = [&](double stretch) {
    const Vector3d F(1 + stretch, 1 - poisson * stretch, 1 - poisson * stretch);
    return energy_limit_value(shape, EnergyMeasure::true_energy, young, limit,
                              corotate(shape, RotationEstimate::centre, affine(shape.rest_nodes, F.asDiagonal())));
  };
  CHECK(value(0) == Approx(1).epsilon(1e-14));
  CHECK(std::abs(value(0.1)) < 1e-12);
  CHECK(value(0.05) == Approx(0.75).epsilon(1e-12));
  CHECK(value(-0.2) == Approx(-3).epsilon(1e-12));
}

TEST_CASE("the energy limit jacobian matches finite differences to second order") {
  Random random(1);
  const double limit = 0.05;
  for (const Matrix8x3d& nodes : {box_nodes({1, 0.8, 1.1}), distorted_nodes()})
    for (const RotationEstimate estimate : rotation_estimates)
      for (const EnergyMeasure measure : {EnergyMeasure::true_energy, EnergyMeasure::paper}) {
        const HexShape shape = make_hex_shape(nodes, poisson);
        const Vector24d x = stacked(deformed(shape.rest_nodes, random, 0.15));
        const auto value = [&](const Vector24d& y) {
          return energy_limit_value(shape, measure, 1, limit, corotate(shape, estimate, as_nodes(y)));
        };
        const Vector24d exact = energy_limit_jacobian(shape, measure, LimitJacobian::exact, estimate, 1, limit,
                                                      corotate(shape, estimate, as_nodes(x)));
        const auto result =
            convergence(0.01, [&](double h) { return relative_error(difference_gradient(value, x, h), exact); });
        CHECK(result.lowest_order > 1.95);
        CHECK(result.highest_order < 2.05);
        CHECK(result.last_error < 1e-4);
      }
}

TEST_CASE("the paper's energy lies between once and twice the true energy") {
  Random random(4);
  const HexShape shape = make_hex_shape(distorted_nodes(), poisson);
  for (int i = 0; i < 200; ++i) {
    const CorotatedHex hex = corotate(shape, RotationEstimate::centre, deformed(shape.rest_nodes, random, 0.3));
    const double ratio =
        elastic_energy(shape.stiffness_paper, young, hex) / elastic_energy(shape.stiffness, young, hex);
    CHECK(ratio >= 1);
    CHECK(ratio <= 2);
  }
}

TEST_CASE("the paper's energy depends on how the lattice lies: the same shear costs twice or once the true energy") {
  const HexShape shape = make_hex_shape(box_nodes({1, 1, 1}), poisson);
  const Matrix3d along_axes = Vector3d(0.1, -0.1, 0).asDiagonal();
  const Matrix3d turn = Eigen::AngleAxisd(std::atan(1.0), Vector3d::UnitZ()).toRotationMatrix();
  CHECK(energy_ratio(shape, along_axes) == Approx(2).epsilon(1e-12));
  CHECK(energy_ratio(shape, turn * along_axes * turn.transpose()) == Approx(1).epsilon(1e-12));

  // uniaxial stretch along an edge, a face diagonal, a space diagonal: 2 - 2 mu sum eps_ik^2 / e_true
  CHECK(energy_ratio(shape, uniaxial({1, 0, 0})) == Approx(2).epsilon(1e-12));
  CHECK(energy_ratio(shape, uniaxial({1, 1, 0})) == Approx(2 - (1 + poisson) / 2).epsilon(1e-12));
  CHECK(energy_ratio(shape, uniaxial({1, 1, 1})) == Approx(2 - (1 + poisson) * 2 / 3).epsilon(1e-12));
}

TEST_CASE("with the true energy the rotation-fixed and the warped jacobian are one, with the paper's they differ") {
  Random random(5);
  const HexShape shape = make_hex_shape(box_nodes(beam_cell), poisson);
  for (int i = 0; i < 20; ++i) {
    const CorotatedHex hex = corotate(shape, RotationEstimate::centre, deformed(shape.rest_nodes, random, 0.01));
    const auto jacobian = [&](EnergyMeasure measure, LimitJacobian kind) {
      return energy_limit_jacobian(shape, measure, kind, RotationEstimate::centre, young, 0.5, hex);
    };
    const Vector24d warped = jacobian(EnergyMeasure::true_energy, LimitJacobian::warped);
    CHECK(warped == jacobian(EnergyMeasure::true_energy, LimitJacobian::fixed_rotation));
    CHECK(warped == jacobian(EnergyMeasure::paper, LimitJacobian::warped));
    CHECK((-0.5 * warped - warped_gradient(shape.stiffness, young, hex)).norm() < 1e-14 * warped.norm());
    const double ratio = jacobian(EnergyMeasure::paper, LimitJacobian::fixed_rotation).norm() / warped.norm();
    CHECK(ratio > 1.05);
    CHECK(ratio < 2);
  }
}
