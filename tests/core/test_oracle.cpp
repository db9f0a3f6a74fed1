// The exact method against a dense interior-point method on small bodies: the same step from the same state.
//
// min Phi(x)  s.t.  1 - U_e/U_max >= 0,  gap_p >= 0     by primal-dual Newton steps on  Phi - mu sum log c_i,  mu -> 0
#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/reference_mechanics.h"

using namespace umax;
using test::ReferenceStep;

namespace {

struct OracleProblem {
  ReferenceStep step;
  std::vector<int> dofs;  // of each of 3 #N: its index among the free ones, or -1
  int num_free = 0;
  Eigen::Index num_gaps = 0;  // surface points that must stay above the ground: all or none
  double cell_size = 1;
};

OracleProblem make_problem(const Model& model, const StepOptions& options, const State& before) {
  OracleProblem problem{test::make_reference_step(model, options, before),
                        {},
                        0,
                        model.obstacles.empty() ? 0 : model.num_points(),
                        model.bodies[0].cell_size};
  for (Eigen::Index i = 0; i < 3 * model.num_nodes(); ++i)
    problem.dofs.push_back(model.node_fixed[i / 3] ? -1 : problem.num_free++);
  return problem;
}

// constraint values: limits [-], then gaps [cells]
VectorXd constraint_values(const OracleProblem& problem, const Points& x) {
  const ReferenceStep& step = problem.step;
  const Eigen::Index num_limits = step.limits.size();
  VectorXd c(num_limits + problem.num_gaps);
  for (Eigen::Index l = 0; l < num_limits; ++l)
    c[l] = 1 -
           test::reference_energy(step.limited[l], test::nodes_at(step, x, step.model->limits[l].hex)) / step.limits[l];
  for (Eigen::Index p = 0; p < problem.num_gaps; ++p)
    c[num_limits + p] = test::ground_gap(problem.step, x, p) / problem.cell_size;
  return c;
}

// first and second derivatives by the free coordinates
struct Derivatives {
  VectorXd gradient;  // of Phi
  MatrixXd hessian;   // of Phi - sum z_i c_i
  MatrixXd jacobian;  // row i: dc_i/dx
  double scale = 0;   // [N] of the forces that balance in the gradient
};

Derivatives differentiate(const OracleProblem& problem, const Points& x, const VectorXd& z) {
  const ReferenceStep& step = problem.step;
  const Model& model = *step.model;
  const Eigen::Index num_limits = step.limits.size();
  Derivatives d{VectorXd::Zero(problem.num_free), MatrixXd::Zero(problem.num_free, problem.num_free),
                MatrixXd::Zero(z.size(), problem.num_free), 0};
  for (Eigen::Index i = 0; i < 3 * model.num_nodes(); ++i) {
    if (problem.dofs[i] < 0) continue;
    const Eigen::Index node = i / 3, axis = i % 3;
    const double velocity = (x(node, axis) - step.before.positions(node, axis)) / step.h;
    const double inertia = model.node_mass[node] * (velocity - step.before.velocities(node, axis)) / step.h;
    const double weight = model.node_mass[node] * step.gravity[axis];
    d.gradient[problem.dofs[i]] += inertia - weight;
    d.scale = std::max({d.scale, std::abs(inertia), std::abs(weight)});
    d.hessian(problem.dofs[i], problem.dofs[i]) += model.node_mass[node] / (step.h * step.h);
  }
  // adds factor times an energy's derivatives; its gradient goes into the row
  const auto add_energy = [&](const test::ReferenceHex& hex, Eigen::Index e, double factor, auto row) {
    const test::NodesOf<double> nodes = test::nodes_at(step, x, e);
    const test::NodesOf<double> force = test::reference_force(hex, nodes);
    const Matrix24d hessian = test::reference_hessian(hex, nodes);
    const auto dof = [&](int a) { return problem.dofs[3 * model.hexes(e, a / 3) + a % 3]; };
    for (int a = 0; a < 24; ++a) {
      if (dof(a) < 0) continue;
      row(dof(a)) += force(a / 3, a % 3);
      for (int b = 0; b < 24; ++b)
        if (dof(b) >= 0) d.hessian(dof(a), dof(b)) += factor * hessian(a, b);
    }
  };
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    add_energy(step.hexes[e], e, 1, [&](int i) -> double& { return d.gradient[i]; });
  for (Eigen::Index l = 0; l < num_limits; ++l) {
    add_energy(step.limited[l], model.limits[l].hex, z[l] / step.limits[l],
               [&](int i) -> double& { return d.jacobian(l, i); });
    d.jacobian.row(l) /= -step.limits[l];
  }
  for (Eigen::Index p = 0; p < problem.num_gaps; ++p)
    for (int n = 0; n < 8; ++n) {
      const int dof = problem.dofs[3 * model.hexes(surface_hex(model, p), n) + 1];
      if (dof >= 0) d.jacobian(num_limits + p, dof) += surface_weights(model, p)[n] / problem.cell_size;
    }
  return d;
}

Points moved(const OracleProblem& problem, const Points& x, const VectorXd& direction, double length) {
  Points result = x;
  for (std::size_t i = 0; i < problem.dofs.size(); ++i)
    if (problem.dofs[i] >= 0) result.data()[i] += length * direction[problem.dofs[i]];
  return result;
}

// the rest shape, turned and moved as the predictor is, above the ground: strictly feasible
Points feasible_start(const OracleProblem& problem) {
  const Model& model = *problem.step.model;
  if (problem.num_free < 3 * model.num_nodes()) return model.rest_positions;
  const Points target = test::predictor(problem.step);
  const Eigen::RowVector3d from = model.rest_positions.colwise().mean(), to = target.colwise().mean();
  const Matrix3d covariance = (model.rest_positions.rowwise() - from).transpose() * (target.rowwise() - to);
  const Eigen::JacobiSVD<Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Points x = (model.rest_positions.rowwise() - from) * (svd.matrixU() * svd.matrixV().transpose());
  x.rowwise() += to;
  double lowest = 1;
  for (Eigen::Index p = 0; p < problem.num_gaps; ++p)
    lowest = std::min(lowest, test::ground_gap(problem.step, x, p) / problem.cell_size);
  if (lowest < 0.1) x.col(1).array() += (0.1 - lowest) * problem.cell_size;
  return x;
}

double barrier(const OracleProblem& problem, const Points& x, const VectorXd& c, double mu) {
  return test::incremental_potential(problem.step, x) - mu * c.array().log().sum();
}

struct OracleSolution {
  Points positions;
  VectorXd multipliers;        // [J]
  double stationarity = 0;     // of the largest term
  double complementarity = 0;  // [J] largest z_i c_i
  int iterations = 0;
};

// one Newton step on the barrier problem; false when it has converged
bool improve(const OracleProblem& problem, double mu, OracleSolution& at) {
  const VectorXd c = constraint_values(problem, at.positions);
  VectorXd& z = at.multipliers;
  const Derivatives d = differentiate(problem, at.positions, z);
  const VectorXd push = d.jacobian.transpose() * z;
  at.stationarity = (d.gradient - push).cwiseAbs().maxCoeff() / std::max(d.scale, push.cwiseAbs().maxCoeff());
  at.complementarity = c.cwiseProduct(z).maxCoeff();
  const double off_path = (c.cwiseProduct(z).array() - mu).abs().maxCoeff() / mu;
  if (at.stationarity < 1e-11 && off_path < 0.5) return false;

  // Newton, made convex with more and more inertia where it is not
  const VectorXd slope = d.gradient - d.jacobian.transpose() * (mu * c.cwiseInverse());
  MatrixXd matrix = d.hessian + d.jacobian.transpose() * (z.cwiseQuotient(c)).asDiagonal() * d.jacobian;
  Eigen::LLT<MatrixXd> factor(matrix);
  for (double more = 0.1; factor.info() != Eigen::Success; more *= 4) {
    for (std::size_t i = 0; i < problem.dofs.size(); ++i)
      if (problem.dofs[i] >= 0)
        matrix(problem.dofs[i], problem.dofs[i]) +=
            more * problem.step.model->node_mass[Eigen::Index(i) / 3] / (problem.step.h * problem.step.h);
    factor.compute(matrix);
  }
  const VectorXd direction = -factor.solve(slope);
  const VectorXd z_direction = mu * c.cwiseInverse() - z - z.cwiseQuotient(c).cwiseProduct(d.jacobian * direction);

  // stay inside, and let the barrier function fall
  const double before = barrier(problem, at.positions, c, mu), promised = slope.dot(direction);
  double length = 1;
  for (int halving = 0; halving < 60; ++halving, length /= 2) {
    const Points trial = moved(problem, at.positions, direction, length);
    const VectorXd trial_c = constraint_values(problem, trial);
    if ((trial_c.array() <= 0.005 * c.array()).any()) continue;
    if (barrier(problem, trial, trial_c, mu) <= before + 1e-4 * length * promised + 1e-13 * std::abs(before)) break;
  }
  double z_length = 1;
  for (Eigen::Index i = 0; i < z.size(); ++i)
    if (z_direction[i] < 0) z_length = std::min(z_length, -0.995 * z[i] / z_direction[i]);
  at.positions = moved(problem, at.positions, direction, length);
  z += z_length * z_direction;
  // multipliers stay near mu / c
  const VectorXd near = mu * constraint_values(problem, at.positions).cwiseInverse();
  z = z.cwiseMin(1e8 * near).cwiseMax(1e-8 * near);
  ++at.iterations;
  return true;
}

OracleSolution solve(const OracleProblem& problem) {
  OracleSolution at;
  at.positions = feasible_start(problem);
  const double unit = problem.step.limits.maxCoeff();
  const VectorXd c = constraint_values(problem, at.positions);
  REQUIRE(c.minCoeff() > 0);
  double mu = unit;
  at.multipliers = mu * c.cwiseInverse();
  for (; mu > 1e-12 * unit; mu *= 0.1)
    for (int iteration = 0; iteration < 60 && improve(problem, mu, at); ++iteration) continue;
  return at;
}

// largest distance of a node between two shapes [cells]
double difference(const OracleProblem& problem, const Points& a, const Points& b) {
  return (a - b).rowwise().norm().maxCoeff() / problem.cell_size;
}

StepOptions oracle_options() {
  StepOptions options{.time_step = 0.01};
  options.solver.tolerance = 1e-6;
  return options;
}

struct Comparison {
  int compared = 0;              // steps
  double travelled = 0;          // [cells] by a node in one of them, at most
  int limits = 0, contacts = 0;  // most active in one of them
};

// steps the body and holds every `stride`-th step against the oracle, to a millionth of a cell
Comparison compare(const Body& body, const std::vector<Obstacle>& obstacles, State state, int steps, int stride) {
  const Model model = make_model({body}, obstacles);
  const StepOptions options = oracle_options();
  Comparison result;
  State before = state;
  int index = 0;
  test::simulate(model, options, steps, state, [&](const StepReport& report, const State& after) {
    REQUIRE(report.status == StepStatus::converged);
    if (index++ % stride == 0 && report.retries == 0) {
      CAPTURE(index, report.limits_active, report.contacts);
      const OracleProblem problem = make_problem(model, options, before);
      const OracleSolution oracle = solve(problem);
      CHECK(oracle.stationarity < 1e-9);
      CHECK(oracle.complementarity < 1e-11 * problem.step.limits.maxCoeff());
      CHECK(difference(problem, after.positions, oracle.positions) <= 1e-6);
      result.travelled = std::max(result.travelled, difference(problem, after.positions, before.positions));
      result.limits = std::max(result.limits, report.limits_active);
      result.contacts = std::max(result.contacts, report.contacts);
      ++result.compared;
    }
    before = after;
  });
  return result;
}

Comparison compare(const Body& body, const std::vector<Obstacle>& obstacles, int steps, int stride) {
  return compare(body, obstacles, rest_state(make_model({body}, obstacles)), steps, stride);
}

}  // namespace

TEST_CASE("a clamped beam at its limits ends each step where an interior-point method does") {
  Body beam = test::make_block({6, 2, 2}, Vector3d::Zero(), 0.1);
  beam.material.young = 1e5;
  for (int node = 0; node < 9; ++node) beam.fixed_nodes.push_back(node);
  test::limit_energy(beam, 0.02);
  const Comparison result = compare(beam, {}, 32, 6);
  CHECK(result.compared >= 5);
  CHECK(result.travelled > 0.05);
  CHECK(result.limits > 8);
}

TEST_CASE("a spinning, stretched block at its limits ends each step where an interior-point method does") {
  Body block = test::make_block({3, 3, 3}, {0, 5, 0}, 0.1);
  block.material.young = 5e4;
  block.spin = {9, -6, 12};
  block.velocity = {1, 2, -1};
  test::limit_energy(block, 0.02);
  State state = rest_state(make_model({block}, {}));
  Matrix3d stretch = Matrix3d::Identity();
  stretch.diagonal() << 1.02, 0.99, 1.01;
  state.positions = state.positions * stretch;
  state.velocities.col(0) += 4 * (state.positions.col(0).array() - 0.15).matrix();
  const Comparison result = compare(block, {}, state, 21, 4);
  CHECK(result.compared >= 5);
  CHECK(result.travelled > 0.05);
  CHECK(result.limits > 8);
}

TEST_CASE("a block that hits frictionless ground ends each step where an interior-point method does") {
  Body block = test::make_block({3, 2, 2}, {0, 1, 0}, 0.1, 1);
  block.material.young = 5e4;
  block.velocity = {0.3, -2, 0};
  block.friction = 0;
  test::limit_energy(block, 0.05);
  // it falls on a corner
  State state = rest_state(make_model({block}, {}));
  state.positions = state.positions * rotation_from_degrees({20, 0, 35}).transpose();
  state.positions.col(1).array() += 0.02 - state.positions.col(1).minCoeff();
  const Comparison result = compare(block, {test::make_ground()}, state, 31, 3);
  CHECK(result.compared >= 5);
  CHECK(result.travelled > 0.05);
  CHECK(result.limits > 3);
  CHECK(result.contacts > 2);
}

TEST_CASE("a block that lands flat on frictionless ground ends each step where an interior-point method does") {
  Body block = test::make_block({3, 3, 3}, {0, 0.015, 0}, 0.1, 1);
  block.material.young = 5e4;
  block.velocity = {0, -2, 0};
  block.friction = 0;
  test::limit_energy(block, 0.01);
  const Comparison result = compare(block, {test::make_ground()}, 21, 4);
  CHECK(result.compared >= 5);
  CHECK(result.travelled > 0.05);
  CHECK(result.limits > 3);
  CHECK(result.contacts > 8);
}

TEST_CASE("a block with limits on parts and peaks ends each step where an interior-point method does") {
  Body beam = test::make_block({4, 1, 1}, Vector3d::Zero(), 0.1);
  beam.material.young = 1e5;
  for (int node = 0; node < 4; ++node) beam.fixed_nodes.push_back(node);
  const EnergyLimitOptions hard{.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.03};
  const auto limited = GENERATE(0, 1, 2, 3);
  CAPTURE(limited);
  PartLimitOptions& parts = beam.part_limits;
  if (limited == 0) parts.volumetric = hard;
  if (limited == 1) parts.deviatoric = hard;
  if (limited == 2) parts.fibre = hard, parts.fibre_direction = {1, 1, 0};
  if (limited == 3) parts.volumetric = parts.fibre = beam.limit = hard, beam.limit.measure = LimitMeasure::peak;
  const Comparison result = compare(beam, {}, 25, 6);
  CHECK(result.compared >= 4);
  CHECK(result.travelled > 0.02);
  CHECK(result.limits > 1);
}
