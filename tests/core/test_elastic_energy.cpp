#include "core/element/elastic_energy.h"

#include <Eigen/LU>

#include "core/element/energy_limit.h"
#include "core/element/material.h"
#include "core/element/rotation.h"
#include "tests/support/catch.h"
#include "tests/support/finite_differences.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double young = 150e3;

struct Sample {
  HexShape shape;
  RotationEstimate estimate;
  EnergyMeasure measure;

  const Matrix24d& K() const { return measured_stiffness(shape, measure); }
  const Matrix8x3d& h() const { return shape.rotation_gradients[int(estimate)]; }

  CorotatedHex at(const Vector24d& x) const { return corotate(shape, estimate, as_nodes(x)); }
  double energy(const Vector24d& x) const { return elastic_energy(K(), young, at(x)); }
  Vector24d gradient(const Vector24d& x) const { return exact_gradient(K(), young, h(), at(x)); }
  Matrix24d hessian(const Vector24d& x) const { return exact_hessian(K(), young, h(), at(x)); }
};

// every rotation estimate, both energies, a box and a distorted hex
std::vector<Sample> all_samples() {
  std::vector<Sample> samples;
  for (const RotationEstimate estimate : rotation_estimates)
    for (const EnergyMeasure measure : {EnergyMeasure::true_energy, EnergyMeasure::paper})
      for (const Matrix8x3d& nodes : {box_nodes({1, 0.8, 1.1}), distorted_nodes()})
        samples.push_back({make_hex_shape(nodes, 0.3), estimate, measure});
  return samples;
}

}  // namespace

TEST_CASE("rigid motion of a hex costs no elastic energy and no force") {
  Random random(1);
  for (const Sample& sample : all_samples())
    for (int i = 0; i < 5; ++i) {
      const Vector24d x = stacked(affine(sample.shape.rest_nodes, random.rotation(), random.vector(10)));
      CHECK(sample.energy(x) < 1e-12);
      CHECK(sample.gradient(x).cwiseAbs().maxCoeff() < 1e-12 * young);
      CHECK(warped_gradient(sample.K(), young, sample.at(x)).cwiseAbs().maxCoeff() < 1e-12 * young);
    }
}

TEST_CASE("energy does not change when the deformed hex is rotated and moved") {
  Random random(2);
  for (const Sample& sample : all_samples()) {
    const Matrix8x3d x = deformed(sample.shape.rest_nodes, random, 0.2);
    const double energy = sample.energy(stacked(x));
    for (int i = 0; i < 5; ++i)
      CHECK(sample.energy(stacked(affine(x, random.rotation(), random.vector(3)))) == Approx(energy).epsilon(1e-12));
  }
}

TEST_CASE("the quadratic form is the strain energy summed over the quadrature points") {
  Random random(3);
  for (const Sample& sample : all_samples()) {
    if (sample.measure == EnergyMeasure::paper) continue;
    const CorotatedHex hex = sample.at(stacked(deformed(sample.shape.rest_nodes, random, 0.2)));
    const Matrix8x3d u = as_nodes(hex.displacement);
    const Moduli m = moduli(young, 0.3);
    double energy = 0;  // lambda/2 tr(eps)^2 + mu eps:eps
    for (int q = 0; q < 8; ++q) {
      const Matrix3d gradient = u.transpose() * sample.shape.gradients[q];
      const Matrix3d eps = 0.5 * (gradient + gradient.transpose());
      energy += sample.shape.weights[q] * (0.5 * m.E2 * eps.trace() * eps.trace() + m.E3 * eps.squaredNorm());
    }
    CHECK(elastic_energy(sample.K(), young, hex) == Approx(energy).epsilon(1e-12));
  }
}

TEST_CASE("a uniaxial stretch s has the energy density Y s^2 / 2") {
  for (const Sample& sample : all_samples()) {
    if (sample.measure == EnergyMeasure::paper) continue;
    for (const double s : {-0.3, 0.05, 0.2}) {
      const Matrix3d axes = Random(4).rotation();  // the direction of the pull does not matter
      const Matrix3d F = axes * Vector3d(1 + s, 1 - 0.3 * s, 1 - 0.3 * s).asDiagonal() * axes.transpose();
      const double energy = sample.energy(stacked(affine(sample.shape.rest_nodes, Random(9).rotation() * F)));
      CHECK(energy / sample.shape.volume == Approx(density_from_stretch(young, s)).epsilon(1e-12));
    }
  }
}

TEST_CASE("the exact gradient matches finite differences of the energy to second order") {
  Random random(5);
  for (const Sample& sample : all_samples()) {
    const Vector24d x = stacked(deformed(sample.shape.rest_nodes, random, 0.15));
    const Vector24d exact = sample.gradient(x);
    const auto result = convergence(0.01, [&](double h) {
      return relative_error(difference_gradient([&](const Vector24d& y) { return sample.energy(y); }, x, h), exact);
    });
    CHECK(result.lowest_order > 1.97);
    CHECK(result.highest_order < 2.03);
    CHECK(result.last_error < 1e-4);
  }
}

TEST_CASE("the exact gradient holds in an inverted hex as long as its rotation is defined") {
  Random random(6);
  for (const Sample& sample : all_samples()) {
    const Matrix3d F = random.rotation() * Vector3d(1.2, -0.3, 1).asDiagonal();
    const Vector24d x = stacked(affine(sample.shape.rest_nodes + random.nodes(0.02), F));
    REQUIRE(sample.at(x).stretch.determinant() < 0);
    const Vector24d exact = sample.gradient(x);
    const auto result = convergence(0.01, [&](double h) {
      return relative_error(difference_gradient([&](const Vector24d& y) { return sample.energy(y); }, x, h), exact);
    });
    CHECK(result.lowest_order > 1.95);
    CHECK(result.highest_order < 2.05);
  }
}

TEST_CASE("the exact hessian matches finite differences of the gradient to second order") {
  Random random(7);
  for (const Sample& sample : all_samples()) {
    const Vector24d x = stacked(deformed(sample.shape.rest_nodes, random, 0.15));
    const Matrix24d exact = sample.hessian(x);
    CHECK((exact - exact.transpose()).norm() < 4e-15 * exact.norm());
    const auto result = convergence(0.01, [&](double h) {
      return relative_error(difference_jacobian([&](const Vector24d& y) { return sample.gradient(y); }, x, h), exact);
    });
    CHECK(result.lowest_order > 1.97);
    CHECK(result.highest_order < 2.03);
    CHECK(result.last_error < 1e-4);
  }
}

TEST_CASE("at rest and under pure stretch the exact hessian is what linear elasticity says") {
  Random random(8);
  for (const Sample& sample : all_samples()) {
    // at rest the rotation's derivative only removes rigid motion, which costs nothing
    const Matrix3d R = random.rotation();
    const Vector24d rest = stacked(affine(sample.shape.rest_nodes, R));
    const CorotatedHex hex = sample.at(rest);
    CHECK(relative_error(sample.hessian(rest), warped_hessian(sample.K(), young, hex)) < 1e-13);
    Matrix24d blocks = Matrix24d::Zero();
    for (int j = 0; j < 8; ++j) blocks.block<3, 3>(3 * j, 3 * j) = R;
    CHECK(relative_error(warped_hessian(sample.K(), young, hex),
                         Matrix24d(young * blocks * sample.K() * blocks.transpose())) < 1e-13);
  }
}

TEST_CASE("the exact gradient has neither net force nor torque, the warped force has a torque") {
  Random random(9);
  for (const Sample& sample : all_samples()) {
    const Matrix8x3d x = deformed(sample.shape.rest_nodes, random, 0.2);
    const CorotatedHex hex = sample.at(stacked(x));
    const Vector24d exact = exact_gradient(sample.K(), young, sample.h(), hex);
    const Vector24d warped = warped_gradient(sample.K(), young, hex);
    const Matrix8x3d centred = x.rowwise() - x.colwise().mean();
    const double scale = warped.norm();  // times a length of 1 m
    CHECK(as_nodes(exact).colwise().sum().norm() < 1e-12 * scale);
    CHECK(as_nodes(warped).colwise().sum().norm() < 1e-12 * scale);
    CHECK(torque(centred, exact).norm() < 1e-12 * scale);
    CHECK(torque(centred, warped).norm() > 1e-3 * scale);
  }
}

TEST_CASE("the warped force is the gradient with the rotation held") {
  Random random(10);
  for (const Sample& sample : all_samples()) {
    const Vector24d x = stacked(deformed(sample.shape.rest_nodes, random, 0.2));
    const CorotatedHex hex = sample.at(x);
    const auto held_energy = [&](const Vector24d& y) {
      const Vector24d u = stacked(as_nodes(y) * hex.rotation - sample.shape.rest_nodes);
      return 0.5 * young * u.dot(sample.K() * u);
    };
    // quadratic in x: central differences are exact but for rounding
    CHECK(relative_error(difference_gradient(held_energy, x, 0.1), warped_gradient(sample.K(), young, hex)) < 1e-10);
  }
}

TEST_CASE("under an affine deformation all rotation estimates and both forces agree") {
  const HexShape shape = make_hex_shape(distorted_nodes(), 0.3);
  Random random(11);
  for (int i = 0; i < 10; ++i) {
    const Matrix8x3d x = affine(shape.rest_nodes, random.rotation() * (Matrix3d::Identity() + random.matrix(0.2)));
    const CorotatedHex centre = corotate(shape, RotationEstimate::centre, x);
    const Vector24d force = warped_gradient(shape.stiffness, young, centre);
    for (const RotationEstimate estimate : rotation_estimates) {
      const CorotatedHex hex = corotate(shape, estimate, x);
      CHECK((hex.rotation - centre.rotation).norm() < 1e-13);
      const Vector24d exact = exact_gradient(shape.stiffness, young, shape.rotation_gradients[int(estimate)], hex);
      CHECK(relative_error(exact, force) < 1e-12);
    }
  }
}

TEST_CASE("flat, collapsed and inverted hexes have finite forces and hessians") {
  for (const Sample& sample : all_samples()) {
    const double scale = young * sample.K().norm();
    for (const Vector3d& stretch : {Vector3d(0, 0, 0), Vector3d(1, 1, 0), Vector3d(1, 0, 0), Vector3d(1, 1, -1),
                                    Vector3d(-1, -1, -1), Vector3d(2, 0.5, -0.5), Vector3d(1, 1e-3, -1e-3)}) {
      const Vector24d x = stacked(affine(sample.shape.rest_nodes, stretch.asDiagonal()));
      CHECK(sample.gradient(x).allFinite());
      CHECK(sample.gradient(x).norm() < 100 * scale);  // 1 / smallest trusted D
      CHECK(sample.hessian(x).allFinite());
    }
  }
}

TEST_CASE("where the rotation is undetermined the torque term fades out continuously") {
  // hourglass modes leave the centre's gradient alone, so s_2 + s_3 is the gap exactly
  const Sample sample{make_hex_shape(box_nodes({1, 1, 1}), 0.3), RotationEstimate::centre, EnergyMeasure::true_energy};
  Random random(12);
  Matrix8x3d hourglass;
  const Vector3d yz = random.vector(0.1), xz = random.vector(0.1), xy = random.vector(0.1), xyz = random.vector(0.1);
  for (int n = 0; n < 8; ++n) {
    const int x = n & 4 ? 1 : -1, y = n & 2 ? 1 : -1, z = n & 1 ? 1 : -1;
    hourglass.row(n) = y * z * yz + x * z * xz + x * y * xy + x * y * z * xyz;
  }
  const auto at_gap = [&](double gap) {
    return stacked(affine(sample.shape.rest_nodes, Vector3d(1, 0.6, -0.6 + gap).asDiagonal()) + hourglass);
  };
  const auto torque_term = [&](double gap) {
    const CorotatedHex hex = sample.at(at_gap(gap));
    return (sample.gradient(at_gap(gap)) - warped_gradient(sample.K(), young, hex)).norm();
  };
  CHECK(torque_term(1e-9) < 0.1 * torque_term(0.01));  // what is left is of the two other directions
  CHECK(torque_term(0.01) == Approx(10 * torque_term(0.1)).epsilon(0.5));

  // no jump between neighbouring shapes on the way
  Vector24d last = sample.gradient(at_gap(0.1));
  double largest_jump = 0;
  for (double gap = 0.1; gap > 1e-5; gap *= 0.999) {
    const Vector24d next = sample.gradient(at_gap(gap));
    largest_jump = std::max(largest_jump, (next - last).norm() / last.norm());
    last = next;
  }
  CHECK(largest_jump < 0.01);
}
