#include "tools/reproduce/printed_equations.h"

#include "core/element/energy_limit.h"
#include "core/element/material.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/finite_differences.h"
#include "tests/support/hex_samples.h"
#include "tools/reproduce/printed_step.h"

using namespace umax;
using namespace umax::test;
using printed::Derivatives;
using printed::ShearModulus;

namespace {

constexpr double young = 150e3, poisson = 0.3;
const Vector3d beam_cell(1.0 / 14, 0.06, 0.06);

// dU/dx of Eq. 13 with R held, which is quadratic: exact but for rounding
Vector24d difference_of_energy(const HexShape& shape, const Moduli& m, const Matrix3d& R, const Matrix8x3d& x) {
  const auto energy = [&](const Matrix8x3d& y) { return printed::equation_13(shape, m, R, y); };
  return difference_gradient(energy, x, 0.1 * shape.rest_nodes.maxCoeff());
}

// a hex clamped at x = 0 whose other nodes fly apart
struct ThrownHex {
  Model model;
  State state;
  StepOptions options{.time_step = 0.01};
};

ThrownHex throw_hex(double limit, double damping) {
  ThrownHex thrown;
  Body body = make_block({1, 1, 1}, Vector3d::Zero(), 0.1);
  body.material.young = young;
  body.material.damping_mass = 100 * damping;
  body.material.damping_stiffness = damping;
  body.fixed_nodes = {0, 1, 2, 3};
  if (limit > 0) limit_energy(body, limit);
  thrown.model = make_model({body}, {});
  thrown.state = rest_state(thrown.model);
  Random random(8);
  for (int node = 4; node < 8; ++node) thrown.state.velocities.row(node) = random.vector(2);
  thrown.options.solver.method = SolverMethod::paper;
  thrown.options.solver.energy = EnergyMeasure::paper;
  thrown.options.solver.jacobian = LimitJacobian::fixed_rotation;
  thrown.options.solver.tolerance = 1e-6;
  return thrown;
}

StepReport step_of(ThrownHex& thrown) {
  Workspace workspace(thrown.model);
  return step(thrown.model, thrown.options, workspace, thrown.state);
}

}  // namespace

TEST_CASE("the paper's energy as a quadratic form is [PPO13] Eq. 16") {
  Random random(2);
  for (const Matrix8x3d& nodes : {box_nodes(beam_cell), distorted_nodes()}) {
    const HexShape shape = make_hex_shape(nodes, poisson);
    const Matrix8x3d x = deformed(nodes, random, 0.1 * nodes.maxCoeff());
    const CorotatedHex hex = corotate(shape, RotationEstimate::kuhn, x);
    CHECK(elastic_energy(shape.stiffness_paper, young, hex) ==
          Approx(printed::equation_13(shape, moduli(young, poisson), hex.rotation, x)).epsilon(1e-11));
  }
}

TEST_CASE("[PPO13] Eq. 17 is the gradient with E3 and H F^-1, and wrong with the printed E2 or with H") {
  Random random(3);
  const HexShape shape = make_hex_shape(box_nodes(beam_cell), poisson);
  const Moduli m = moduli(young, poisson);
  double mean_error_E2 = 0;
  constexpr int num_samples = 30;
  for (int i = 0; i < num_samples; ++i) {
    const Matrix8x3d x = deformed(shape.rest_nodes, random, 0.01);
    const CorotatedHex hex = corotate(shape, RotationEstimate::centre, x);
    const Vector24d difference = difference_of_energy(shape, m, hex.rotation, x);
    const auto error = [&](ShearModulus shear, Derivatives derivatives) {
      return relative_error(printed::equation_17(shape, m, hex.rotation, x, shear, derivatives), difference);
    };
    CHECK(error(ShearModulus::E3, Derivatives::material) < 1e-9);
    const Vector24d library = energy_limit_jacobian(shape, EnergyMeasure::paper, LimitJacobian::fixed_rotation,
                                                    RotationEstimate::centre, young, 2.0, hex);
    CHECK(relative_error(Vector24d(-2.0 * library), difference) < 1e-9);

    const double error_E2 = error(ShearModulus::E2, Derivatives::material);
    CHECK(error_E2 > 0.02);
    mean_error_E2 += error_E2 / num_samples;
    CHECK(error(ShearModulus::E3, Derivatives::natural) > 0.8);
  }
  CHECK(mean_error_E2 > 0.1);
  CHECK(mean_error_E2 < 0.5);
}

TEST_CASE("[PPO13] Eq. 17's E2 does no harm at Poisson's ratio 1/4") {
  Random random(4);
  const HexShape shape = make_hex_shape(box_nodes(beam_cell), 0.25);
  const Matrix8x3d x = deformed(shape.rest_nodes, random, 0.01);
  const Moduli m = moduli(young, 0.25);
  const Matrix3d R = corotate(shape, RotationEstimate::centre, x).rotation;
  CHECK(relative_error(printed::equation_17(shape, m, R, x, ShearModulus::E2, Derivatives::material),
                       difference_of_energy(shape, m, R, x)) < 1e-9);
}

TEST_CASE("[PPO13] Eq. 9 and 17 of H are right for a cube of 2 m only") {
  Random random(5);
  const Moduli m = moduli(young, poisson);
  for (const double edge : {2.0, 1.0, 0.1}) {
    const HexShape shape = make_hex_shape(box_nodes(Vector3d::Constant(edge)), poisson);
    const Matrix8x3d x = deformed(shape.rest_nodes, random, 0.1 * edge);
    const Matrix3d R = corotate(shape, RotationEstimate::centre, x).rotation;
    const Vector24d difference = difference_of_energy(shape, m, R, x);
    const Vector24d of_H = printed::equation_17(shape, m, R, x, ShearModulus::E3, Derivatives::natural);
    CHECK(relative_error(of_H, Vector24d(0.5 * edge * difference)) < 1e-9);
    CHECK(relative_error(printed::equation_9_with_shear(shape), Matrix24d(0.25 * edge * edge * shape.stiffness)) <
          1e-13);
    // three rows of H: on a cube of 2 m they are the material ones
    const Matrix24d natural = printed::equation_9(shape, Derivatives::natural);
    CHECK(relative_error(natural, Matrix24d(0.25 * edge * edge * printed::equation_9(shape, Derivatives::material))) <
          1e-13);
  }
}

TEST_CASE("[PPO13] Eq. 15 has the right sign") {
  Random random(6);
  const double limit = 2.0;
  const HexShape shape = make_hex_shape(box_nodes(beam_cell), poisson);
  const Moduli m = moduli(young, poisson);
  const Matrix8x3d x = deformed(shape.rest_nodes, random, 0.01);
  const Matrix3d R = corotate(shape, RotationEstimate::centre, x).rotation;
  const auto C = [&](const Matrix8x3d& y) { return 1 - printed::equation_13(shape, m, R, y) / limit; };
  const Vector24d sum = printed::equation_17(shape, m, R, x, ShearModulus::E3, Derivatives::material);
  CHECK(relative_error(printed::equation_15(sum, limit), difference_gradient(C, x, 0.01)) < 1e-9);
}

TEST_CASE("[PPO13] Eq. 19 is right: the damping force at the start cancels") {
  ThrownHex damped = throw_hex(0, 0.02), free = throw_hex(0, 0);
  const Vector24d literal = printed::equation_19(damped.model, damped.options, damped.state);
  const Vector24d undamped = printed::equation_19(free.model, free.options, free.state);
  step_of(damped);
  CHECK(relative_error(literal, printed::in_hex_order(damped.model, damped.state.velocities)) < 1e-12);
  CHECK(relative_error(literal, undamped) > 0.3);  // damping does show
}

TEST_CASE("[PPO13] Eq. 21 with the total lambda holds loose limits only, adding to the last iterate holds all") {
  ThrownHex unlimited = throw_hex(1, 0);
  const Vector24d end =
      printed::in_hex_order(unlimited.model, unlimited.state.positions) +
      unlimited.options.time_step * printed::equation_19(unlimited.model, unlimited.options, unlimited.state);
  const HexShape& shape = unlimited.model.shapes[0];
  const double energy =
      elastic_energy(shape.stiffness_paper, young, corotate(shape, RotationEstimate::centre, as_nodes(end)));
  for (const double share : {0.8, 0.1, 0.01}) {
    ThrownHex limited = throw_hex(share * energy, 0);
    const double restarted = printed::equation_21_energy_ratio(limited.model, limited.options, limited.state);
    const StepReport report = step_of(limited);
    CAPTURE(share, restarted, report.max_energy_ratio);
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_energy_ratio < 1 + 1e-6);
    if (share > 0.5)
      CHECK(restarted < 1 + 1e-6);
    else
      CHECK(restarted > 2);
  }
}
