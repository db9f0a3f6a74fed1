#include "core/exact_step.h"

#include <algorithm>
#include <cmath>

#include "core/evaluation.h"
#include "core/gauss_seidel.h"
#include "core/limit_law.h"

namespace umax {
namespace {

constexpr double relative_penalty = 1e4;   // rho / U_max
constexpr double joining_share = 0.5;      // of the penetration tolerance: deeper vertices join the working set
constexpr int max_contact_rounds = 10;     // detections per factorisation
constexpr int normal_updates = 6;           // iterations after which contacts keep their normals
constexpr double start_step_share = 0.05;  // of a cell: a larger last step means that the iteration still moves

// the step's unknowns as they are improved, and what is known about them
struct Iterate {
  Points positions;
  VectorXd multipliers;           // #E force-level [J]
  std::vector<Contact> contacts;  // working set, impulses in N s
  Evaluation evaluation;          // at positions
  double last_step = 0;           // [cells] largest node displacement of the last iteration
};

// what decides whether the iterate is the solution
struct Quality {
  double kkt = 0;
  double max_ratio = 0;        // U/U_max of hard limits
  double complementarity = 0;  // |U/U_max - 1| where a multiplier pushes
  double depth = 0;            // deepest working-set contact, in penetration tolerances
};

LimitKind limit_kind(const Model& model, Eigen::Index hex) {
  return model.bodies[model.hex_body[hex]].limit.kind;
}

// lambda/U_max, or the barrier's slope: the factor on G in the gradient of the Lagrangian
VectorXd limit_factors(const StepProblem& problem, const Iterate& iterate) {
  VectorXd factors = VectorXd::Zero(problem.limits.size());
  for (Eigen::Index e = 0; e < factors.size(); ++e) {
    const LimitKind kind = limit_kind(*problem.model, e);
    if (kind == LimitKind::hard) factors[e] = iterate.multipliers[e] / problem.limits[e];
    if (kind == LimitKind::soft)
      factors[e] = soft_limit_terms(iterate.evaluation.energy[e], problem.limits[e], {}).force;
  }
  return factors;
}

Quality assess(const StepProblem& problem, const Iterate& iterate) {
  const Model& model = *problem.model;
  Quality quality;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    if (limit_kind(model, e) != LimitKind::hard) continue;
    const double ratio = iterate.evaluation.energy[e] / problem.limits[e];
    quality.max_ratio = std::max(quality.max_ratio, ratio);
    if (iterate.multipliers[e] > problem.options->solver.tolerance * problem.limits[e])
      quality.complementarity = std::max(quality.complementarity, std::abs(1 - ratio));
  }
  for (const Contact& contact : iterate.contacts)
    quality.depth = std::max(quality.depth, -contact.gap / tolerance_depth(model, contact.hex));
  quality.kkt =
      kkt_residual(problem, iterate.evaluation, iterate.positions, limit_factors(problem, iterate), iterate.contacts);
  return quality;
}

bool is_solution(const Quality& quality, const Iterate& iterate, double tolerance) {
  return quality.kkt <= tolerance && quality.max_ratio <= 1 + tolerance && quality.complementarity <= tolerance &&
         quality.depth <= joining_share && iterate.last_step <= start_step_share;
}

// force, stiffening and rank-one weight of every limit at the iterate
std::vector<LimitTerms> linearise_limits(const StepProblem& problem, const Iterate& iterate) {
  std::vector<LimitTerms> terms(problem.limits.size());
  for (Eigen::Index e = 0; e < problem.limits.size(); ++e) {
    const double energy = iterate.evaluation.energy[e], limit = problem.limits[e];
    const LimitKind kind = limit_kind(*problem.model, e);
    if (kind == LimitKind::hard)
      terms[e] = hard_limit_terms(energy, limit, iterate.multipliers[e], relative_penalty * limit);
    else if (kind == LimitKind::soft)
      terms[e] = soft_limit_terms(energy, limit, {});
  }
  return terms;
}

// the matrix of one element; `exact` false: warped stiffness, positive semi-definite
void element_matrix(const StepProblem& problem, const Evaluation& evaluation, const LimitTerms& terms, Eigen::Index e,
                    bool exact, Matrix24d& element) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  const HexShape& shape = model.shapes[model.hex_shape[e]];
  const Matrix8x3d& h = shape.rotation_gradients[int(solver.rotation)];
  const CorotatedHex& hex = evaluation.hexes[e];
  const auto hessian = [&](const Matrix24d& K) -> Matrix24d {
    return exact ? exact_hessian(K, problem.young[e], h, hex) : warped_hessian(K, problem.young[e], hex);
  };
  element = hessian(shape.stiffness);
  if (terms.stiffening > 0) {
    if (solver.energy == EnergyMeasure::true_energy)
      element *= 1 + terms.stiffening;
    else
      element += terms.stiffening * hessian(measured_stiffness(shape, solver.energy));
  }
  if (terms.rank_one > 0) {
    const Vector24d G = evaluation.limit_gradient(e);
    element.noalias() += terms.rank_one * G * G.transpose();
  }
  if (problem.damping_stiffness[e] > 0) {
    const CorotatedHex start = corotate(shape, solver.rotation, hex_nodes(model, problem.positions_t0, e));
    element += problem.damping_stiffness[e] / problem.h * warped_hessian(shape.stiffness, problem.young[e], start);
  }
}

// factors A; with the exact Hessian where that is positive definite
int factorize(const StepProblem& problem, const Evaluation& evaluation, const std::vector<LimitTerms>& terms,
              Workspace::Data& workspace) {
  const double h = problem.h;
  const VectorXd mass = (problem.model->node_mass.array() * (1 / (h * h) + problem.damping_mass.array() / h)).matrix();
  int attempts = 0;
  for (const bool exact : {true, false}) {
    reset(workspace.matrix);
    add_mass(mass, 1, workspace.matrix);
    add_elements(workspace.matrix, [&](Eigen::Index e, Matrix24d& element) {
      element_matrix(problem, evaluation, terms[e], e, exact, element);
    });
    ++attempts;
    if (workspace.cholesky.factorize(workspace.matrix)) break;
  }
  return attempts;
}

// gradient of the augmented potential without contacts, fixed nodes zero
VectorXd gradient(const StepProblem& problem, const Iterate& iterate, const std::vector<LimitTerms>& terms) {
  const Model& model = *problem.model;
  VectorXd sum = inertia_gradient(problem, iterate.positions) + gather(model, iterate.evaluation.elastic) +
                 gather(model, iterate.evaluation.damping);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    if (terms[e].force > 0)
      for (int n = 0; n < 8; ++n)
        sum.segment<3>(3 * model.hexes(e, n)) +=
            terms[e].force * iterate.evaluation.limit_gradient(e).segment<3>(3 * n);
  clear_fixed(model, sum);
  return sum;
}

// J^T for the three world directions of the contacts from `first` on
MatrixXd contact_columns(const Model& model, const std::vector<Contact>& contacts, std::size_t first) {
  MatrixXd columns = MatrixXd::Zero(3 * model.num_nodes(), 3 * Eigen::Index(contacts.size() - first));
  for (std::size_t i = first; i < contacts.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      spread(model, contacts[i], Vector3d::Unit(axis), columns.col(3 * Eigen::Index(i - first) + axis));
  clear_fixed(model, columns);
  return columns;
}

// displacement-level contact problem at the iterate: unknowns are forces [N], w the motion relative to the obstacle [m]
ComplementarityProblem contact_problem(const StepProblem& problem, const Iterate& iterate, const VectorXd& free_step,
                                       MatrixXd W) {
  ComplementarityProblem contact;
  contact.q.resize(W.rows());
  const Points moved = iterate.positions - problem.positions_t0;
  const Points step = unflatten(free_step);
  for (std::size_t i = 0; i < iterate.contacts.size(); ++i) {
    const Contact& c = iterate.contacts[i];
    const Vector3d relative = embedded_position(*problem.model, moved, c.hex, c.weights) - c.obstacle_motion;
    contact.q.segment<3>(3 * Eigen::Index(i)) = relative + embedded_position(*problem.model, step, c.hex, c.weights);
    contact.contacts.push_back({c.normal, c.friction, c.gap - c.normal.dot(relative)});
  }
  contact.W = std::move(W);
  return contact;
}

// dx = -A^-1 grad + A^-1 J^T f; vertices that dx would push in too deep join the working set against the same factor
VectorXd solve_step(const StepProblem& problem, const SparseCholesky& cholesky, const VectorXd& grad, Iterate& iterate,
                    StepReport& report) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  VectorXd free_step = -grad;
  cholesky.solve(free_step);
  VectorXd step = free_step;
  MatrixXd half(free_step.size(), 0);  // L^-1 J^T
  for (int round = 0; round < max_contact_rounds; ++round) {
    const std::size_t known = std::size_t(half.cols() / 3);
    if (known < iterate.contacts.size()) {
      MatrixXd columns = contact_columns(model, iterate.contacts, known);
      cholesky.half_solve(columns);
      half.conservativeResize(Eigen::NoChange, half.cols() + columns.cols());
      half.rightCols(columns.cols()) = columns;
    }
    if (half.cols() > 0) {
      VectorXd force(half.cols());
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
        force.segment<3>(3 * Eigen::Index(i)) = iterate.contacts[i].impulse / problem.h;
      MatrixXd W = half.transpose() * half;
      report.linear_iterations +=
          gauss_seidel(contact_problem(problem, iterate, free_step, std::move(W)),
                       {.max_sweeps = solver.max_sweeps, .tolerance = std::min(1e-6, 1e-2 * solver.tolerance)}, force)
              .sweeps;
      VectorXd push = VectorXd::Zero(step.size());
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i) {
        iterate.contacts[i].impulse = problem.h * force.segment<3>(3 * Eigen::Index(i));
        spread(model, iterate.contacts[i], force.segment<3>(3 * Eigen::Index(i)), push);
      }
      clear_fixed(model, push);
      cholesky.solve(push);
      step = free_step + push;
    }
    const Points trial = iterate.positions + unflatten(step);
    const std::size_t before = iterate.contacts.size();
    if (add_contacts(problem.contact, trial, joining_share, iterate.contacts) == 0) break;
    std::vector<Contact> added(iterate.contacts.begin() + std::ptrdiff_t(before), iterate.contacts.end());
    update_contacts(problem.contact, iterate.positions, added);  // the linearisation stands at the iterate
    std::copy(added.begin(), added.end(), iterate.contacts.begin() + std::ptrdiff_t(before));
  }
  return step;
}

// no node moves further than one cell in one iteration
double step_scale(const Model& model, const VectorXd& step, double& largest_in_cells) {
  largest_in_cells = 0;
  for (const Model::BodyRange& body : model.bodies)
    for (int node = body.first_node; node < body.first_node + body.num_nodes; ++node)
      largest_in_cells = std::max(largest_in_cells, step.segment<3>(3 * node).norm() / body.cell_size);
  return largest_in_cells > 1 ? 1 / largest_in_cells : 1;
}

void update_multipliers(const StepProblem& problem, const VectorXd& step, Iterate& iterate) {
  const Model& model = *problem.model;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    if (limit_kind(model, e) != LimitKind::hard) continue;
    const double limit = problem.limits[e], ratio = iterate.evaluation.energy[e] / limit;
    const double t = iterate.multipliers[e] + relative_penalty * limit * (ratio - 1);
    double& multiplier = iterate.multipliers[e];
    if (t <= 0) {
      multiplier = 0;
      continue;
    }
    double change = 0;  // G . dx
    for (int n = 0; n < 8; ++n)
      change += iterate.evaluation.limit_gradient(e).segment<3>(3 * n).dot(step.segment<3>(3 * model.hexes(e, n)));
    multiplier = std::max(0.0, t + relative_penalty * change);
  }
}

Iterate start(const StepProblem& problem, const State& state) {
  Iterate iterate;
  iterate.positions = problem.positions_t0 + problem.h * problem.velocities_t0;
  for (Eigen::Index node = 0; node < iterate.positions.rows(); ++node)
    if (problem.model->node_fixed[node]) iterate.positions.row(node) = problem.positions_t0.row(node);
  iterate.multipliers = state.limit_multipliers;
  iterate.contacts = recall_contacts(problem, state, iterate.positions);
  return iterate;
}

}  // namespace

StepReport exact_step(const StepProblem& problem, Workspace::Data& workspace, State& state) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  StepReport report;
  Iterate iterate = start(problem, state);
  while (true) {
    evaluate(problem, iterate.positions, iterate.evaluation);
    if (report.sqp_iterations < normal_updates)
      update_contacts(problem.contact, iterate.positions, iterate.contacts);
    else
      follow_contacts(problem.contact, iterate.positions, iterate.contacts);
    const int added = add_contacts(problem.contact, iterate.positions, joining_share, iterate.contacts);
    const Quality quality = assess(problem, iterate);
    report.kkt_residual = quality.kkt;
    if (problem.options->on_iteration)
      problem.options->on_iteration(report.sqp_iterations, quality.max_ratio, quality.depth, quality.kkt);
    if (added == 0 && is_solution(quality, iterate, solver.tolerance)) break;
    if (report.sqp_iterations == solver.max_newton_iterations) {
      report.status = StepStatus::iteration_limit;
      break;
    }
    ++report.sqp_iterations;
    const std::vector<LimitTerms> terms = linearise_limits(problem, iterate);
    report.factorisations += factorize(problem, iterate.evaluation, terms, workspace);
    VectorXd step = solve_step(problem, workspace.cholesky, gradient(problem, iterate, terms), iterate, report);
    step *= step_scale(model, step, iterate.last_step);
    update_multipliers(problem, step, iterate);
    iterate.positions += unflatten(step);
  }

  state.velocities = (iterate.positions - problem.positions_t0) / problem.h;
  state.positions = iterate.positions;
  state.limit_multipliers = iterate.multipliers;
  report.contacts = int(iterate.contacts.size());
  report.limits_active = int((limit_factors(problem, iterate).array() > 0).count());
  remember_contacts(iterate.contacts, state);
  return report;
}

}  // namespace umax
