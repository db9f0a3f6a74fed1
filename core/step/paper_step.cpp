#include "core/step/paper_step.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/hex_limits.h"
#include "core/problem/evaluation.h"
#include "core/problem/step_contacts.h"
#include "core/problem/step_length.h"
#include "core/step/contact_counts.h"

namespace umax {
namespace {

// the step's unknowns as they are improved
struct PaperIterate {
  VectorXd velocity;              // 3 #N
  Points positions;               // x0 + h v
  VectorXd ratios;                // #L U/U_max at positions
  std::vector<char> candidate;    // #L violated at some iteration of this step
  VectorXd multipliers;           // #L accumulated, force-level
  std::vector<Contact> contacts;  // working set
  MatrixXd contact_columns;       // 3 #N x 3 #C: h A^-1 J^T of the contacts, velocities under unit forces
};

// A of Eq. 19 with the warped stiffness at x0; returns h f_el(x0)
VectorXd assemble(const StepProblem& problem, SystemMatrix& matrix) {
  const Model& model = *problem.model;
  const double h = problem.h;
  reset(matrix);
  add_mass((model.node_mass.array() * (1 + h * problem.damping_mass.array())).matrix(), 1, matrix);
  HexColumns gradients(24, model.num_hexes());
  add_elements(matrix, [&](Eigen::Index e, Matrix24d& element) {
    const HexShape& shape = model.shapes[model.hex_shape[e]];
    const CorotatedHex hex =
        corotate(shape, problem.options->solver.rotation, hex_nodes(model, problem.positions_t0, e));
    element =
        (h * h + h * problem.damping_stiffness[e]) * warped_hessian(shape.stiffness, problem.materials.young[e], hex);
    gradients.col(e) = warped_gradient(shape.stiffness, problem.materials.young[e], hex);
  });
  return -h * gather(model, gradients);
}

// v* of Eq. 19
VectorXd unconstrained_velocity(const StepProblem& problem, VectorXd elastic_impulse, const SparseCholesky& cholesky) {
  const Model& model = *problem.model;
  VectorXd b = std::move(elastic_impulse);
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    b.segment<3>(3 * node) +=
        model.node_mass[node] * (problem.velocities_t0.row(node).transpose() + problem.h * problem.options->gravity);
  if (const Points& forces = problem.options->forces; forces.rows() > 0) b += problem.h * flatten(forces);
  clear_fixed(model, b);
  cholesky.solve(b);
  return b;
}

void move_to_velocity(const StepProblem& problem, PaperIterate& iterate) {
  iterate.positions = problem.positions_t0 + problem.h * unflatten(iterate.velocity);
}

// h A^-1 J^T for the three world directions of the contacts from `first` on
void append_contact_columns(const StepProblem& problem, const SparseCholesky& cholesky, std::size_t first,
                            PaperIterate& iterate) {
  const Model& model = *problem.model;
  const Eigen::Index old = 3 * Eigen::Index(first), count = 3 * Eigen::Index(iterate.contacts.size()) - old;
  if (count == 0) return;
  MatrixXd columns = MatrixXd::Zero(3 * model.num_nodes(), count);
  for (std::size_t i = first; i < iterate.contacts.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      spread(model, iterate.contacts[i], Vector3d::Unit(axis), columns.col(3 * Eigen::Index(i - first) + axis));
  clear_fixed(model, columns);
  cholesky.solve(columns);
  iterate.contact_columns.conservativeResize(3 * model.num_nodes(), old + count);
  iterate.contact_columns.rightCols(count) = problem.h * columns;
}

// contacts of the last step push from the start
void apply_remembered_forces(PaperIterate& iterate) {
  for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
    iterate.velocity += iterate.contact_columns.middleCols<3>(3 * Eigen::Index(i)) * iterate.contacts[i].force;
}

// Contacts of obstacles' edges and of other bodies slide through the material: their columns follow, and so does the
// effect of their forces.
void refresh_sliding_columns(const StepProblem& problem, const SparseCholesky& cholesky, PaperIterate& iterate) {
  for (std::size_t i = 0; i < iterate.contacts.size(); ++i) {
    if (iterate.contacts[i].point.kind == ContactKind::vertex) continue;
    MatrixXd columns = MatrixXd::Zero(iterate.velocity.size(), 3);
    for (int axis = 0; axis < 3; ++axis)
      spread(*problem.model, iterate.contacts[i], Vector3d::Unit(axis), columns.col(axis));
    clear_fixed(*problem.model, columns);
    cholesky.solve(columns);
    columns *= problem.h;
    auto known = iterate.contact_columns.middleCols<3>(3 * Eigen::Index(i));
    iterate.velocity += (columns - known) * iterate.contacts[i].force;
    known = columns;
  }
}

// rows dC/dx of the candidate limits, one 24-vector each
std::vector<Vector24d> limit_rows(const StepProblem& problem, const std::vector<int>& limits, const Points& positions) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  std::vector<Vector24d> rows(limits.size());
  parallel_blocks(Eigen::Index(limits.size()), 8, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const HexLimit& limit = model.limits[limits[i]];
      const int e = limit.hex;
      const CorotatedHex hex =
          corotate(model.shapes[model.hex_shape[e]], solver.rotation, hex_nodes(model, positions, e));
      rows[i] = limited_gradient(model, solver.energy, solver.jacobian, solver.rotation, limit,
                                 problem.materials.young[e], hex) /
                -problem.materials.limits[limits[i]];
      for (int n = 0; n < 8; ++n)
        if (model.node_fixed[model.hexes(e, n)]) rows[i].segment<3>(3 * n).setZero();
    }
  });
  return rows;
}

MatrixXd scatter(const Model& model, const std::vector<int>& limits, const std::vector<Vector24d>& rows) {
  MatrixXd columns = MatrixXd::Zero(3 * model.num_nodes(), Eigen::Index(limits.size()));
  for (std::size_t i = 0; i < limits.size(); ++i)
    for (int n = 0; n < 8; ++n)
      columns.col(Eigen::Index(i)).segment<3>(3 * model.hexes(model.limits[limits[i]].hex, n)) =
          rows[i].segment<3>(3 * n);
  return columns;
}

// h J A^-1 J^T row by row: J is sparse (8 nodes a row), h A^-1 J^T given
MatrixXd delassus(const StepProblem& problem, const PaperIterate& iterate, const std::vector<int>& limits,
                  const std::vector<Vector24d>& rows, const MatrixXd& limit_columns) {
  const Model& model = *problem.model;
  const Eigen::Index num_contact_rows = iterate.contact_columns.cols(), num_limits = limit_columns.cols();
  MatrixXd W = MatrixXd::Zero(num_contact_rows + num_limits, num_contact_rows + num_limits);
  const auto fill = [&](Eigen::Index column, const auto& response) {
    for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
      W.col(column).segment<3>(3 * Eigen::Index(i)) = contact_motion(model, iterate.contacts[i], response);
    for (std::size_t l = 0; l < limits.size(); ++l) {
      double sum = 0;
      for (int n = 0; n < 8; ++n)
        sum += rows[l].segment<3>(3 * n).dot(
            response.template segment<3>(3 * model.hexes(model.limits[limits[l]].hex, n)));
      W(num_contact_rows + Eigen::Index(l), column) = sum;
    }
  };
  for (Eigen::Index c = 0; c < num_contact_rows; ++c) fill(c, iterate.contact_columns.col(c));
  for (Eigen::Index c = 0; c < num_limits; ++c) fill(num_contact_rows + c, limit_columns.col(c));
  return W;
}

// Eq. 23 at the current velocity: contact forces are totals, limit multipliers increments. Gaps and ratios were taken
// at the positions; the velocity may have changed since (refresh_sliding_columns).
ComplementarityProblem linearise(const StepProblem& problem, const PaperIterate& iterate,
                                 const std::vector<int>& limits, const std::vector<Vector24d>& rows, MatrixXd W,
                                 const VectorXd& z) {
  const Model& model = *problem.model;
  ComplementarityProblem lcp;
  const Eigen::Index num_contact_rows = 3 * Eigen::Index(iterate.contacts.size());
  lcp.num_limits = int(limits.size());
  lcp.q = VectorXd::Zero(W.rows());
  lcp.contacts = contact_rows(problem, iterate.positions, iterate.contacts).rows;
  const Points velocity = unflatten(iterate.velocity);
  const Points measured = (iterate.positions - problem.positions_t0) / problem.h;
  for (std::size_t i = 0; i < iterate.contacts.size(); ++i) {
    const Contact& contact = iterate.contacts[i];
    lcp.q.segment<3>(3 * Eigen::Index(i)) =
        contact_motion(model, contact, iterate.velocity) - contact.obstacle_motion / problem.h;
    lcp.contacts[i].bias /= problem.h;
  }
  for (std::size_t i = 0; i < limits.size(); ++i) {
    double& q = lcp.q[num_contact_rows + Eigen::Index(i)];
    q = (1 - iterate.ratios[limits[i]]) / problem.h;
    for (int n = 0; n < 8; ++n) {
      const int node = model.hexes(model.limits[limits[i]].hex, n);
      q += rows[i].segment<3>(3 * n).dot((velocity.row(node) - measured.row(node)).transpose());
    }
  }
  lcp.q -= W.leftCols(num_contact_rows) * z.head(num_contact_rows);
  lcp.W = std::move(W);
  return lcp;
}

// one re-linearisation: Jacobians at the current positions, one Gauss-Seidel, velocities corrected
int correct(const StepProblem& problem, const SparseCholesky& cholesky, PaperIterate& iterate) {
  const Model& model = *problem.model;
  std::vector<int> limits;
  for (int l = 0; l < int(iterate.candidate.size()); ++l)
    if (iterate.candidate[l]) limits.push_back(l);
  refresh_sliding_columns(problem, cholesky, iterate);
  const std::vector<Vector24d> rows = limit_rows(problem, limits, iterate.positions);
  MatrixXd limit_columns = scatter(model, limits, rows);
  cholesky.solve(limit_columns);
  limit_columns *= problem.h;

  const Eigen::Index num_contact_rows = iterate.contact_columns.cols();
  VectorXd z = VectorXd::Zero(num_contact_rows + Eigen::Index(limits.size()));
  for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
    z.segment<3>(3 * Eigen::Index(i)) = iterate.contacts[i].force;
  const VectorXd before = z;
  const ComplementarityProblem lcp =
      linearise(problem, iterate, limits, rows, delassus(problem, iterate, limits, rows, limit_columns), z);
  const SolverOptions& solver = problem.options->solver;
  const GaussSeidelResult result =
      gauss_seidel(lcp, {.max_sweeps = solver.max_sweeps, .tolerance = solver.sweep_tolerance}, z);

  const VectorXd change = z - before;
  iterate.velocity += iterate.contact_columns * change.head(num_contact_rows) +
                      limit_columns * change.tail(Eigen::Index(limits.size()));
  for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
    iterate.contacts[i].force = z.segment<3>(3 * Eigen::Index(i));
  for (std::size_t i = 0; i < limits.size(); ++i)
    iterate.multipliers[limits[i]] += z[num_contact_rows + Eigen::Index(i)];
  return result.sweeps;
}

// deepest working-set gap relative to its tolerance; negative beyond -1 means too deep
double worst_gap(const Model& model, const std::vector<Contact>& contacts) {
  double worst = 0;
  for (const Contact& contact : contacts) worst = std::min(worst, contact.gap / tolerance_depth(model, contact));
  return worst;
}

// evaluates limits and contacts at the current positions; true if all hold
bool constraints_hold(const StepProblem& problem, const SparseCholesky& cholesky, PaperIterate& iterate) {
  const double tolerance = problem.options->solver.tolerance;
  iterate.ratios = limit_ratios(*problem.model, problem.options->solver, problem.materials, iterate.positions);
  bool hold = true;
  for (Eigen::Index l = 0; l < iterate.ratios.size(); ++l)
    if (iterate.ratios[l] > 1) {
      iterate.candidate[l] = 1;
      hold = hold && iterate.ratios[l] <= 1 + tolerance;
    }
  const LastApart apart(problem.positions_t0);
  update_contacts(problem.contact, apart, iterate.positions, iterate.contacts);
  hold = hold && worst_gap(*problem.model, iterate.contacts) >= -problem.joining_share;
  const std::size_t known = iterate.contacts.size();
  const int added = add_contacts(problem.contact, apart, iterate.positions, problem.joining_share, iterate.contacts);
  append_contact_columns(problem, cholesky, known, iterate);
  return hold && added == 0;
}

}  // namespace

StepReport paper_step(const StepProblem& problem, Workspace::Data& workspace, State& state) {
  const Model& model = *problem.model;
  StepReport report;
  SystemMatrix& matrix = matrix_of_all(*problem.model, workspace);
  VectorXd elastic_impulse = assemble(problem, matrix);
  workspace.all.cholesky.factorize(matrix);
  report.factorisations = 1;

  PaperIterate iterate;
  iterate.velocity = unconstrained_velocity(problem, std::move(elastic_impulse), workspace.all.cholesky);
  iterate.candidate.assign(model.limits.size(), 0);
  iterate.multipliers = VectorXd::Zero(Eigen::Index(model.limits.size()));
  iterate.contact_columns.resize(3 * model.num_nodes(), 0);
  move_to_velocity(problem, iterate);
  iterate.contacts = recall_contacts(problem, state, iterate.positions);
  append_contact_columns(problem, workspace.all.cholesky, 0, iterate);
  apply_remembered_forces(iterate);
  move_to_velocity(problem, iterate);

  bool must_solve = !iterate.contacts.empty();  // remembered forces are a guess, not a solution
  double largest_move = 0;
  while (true) {
    const bool hold = constraints_hold(problem, workspace.all.cholesky, iterate);
    if (problem.options->on_iteration)
      problem.options->on_iteration({.iteration = report.sqp_iterations,
                                     .max_energy_ratio = iterate.ratios.size() > 0 ? iterate.ratios.maxCoeff() : 0,
                                     .max_penetration = deepest(iterate.contacts),
                                     .largest_move = largest_move,
                                     .limits_active = count_hexes(model, iterate.multipliers),
                                     .contacts = int(iterate.contacts.size())});
    if (hold && !must_solve) break;
    must_solve = false;
    if (report.sqp_iterations == problem.options->solver.max_iterations) {
      report.status = StepStatus::iteration_limit;
      break;
    }
    ++report.sqp_iterations;
    report.linear_iterations += correct(problem, workspace.all.cholesky, iterate);
    const Points before = iterate.positions;
    move_to_velocity(problem, iterate);
    largest_move = umax::largest_move(model, flatten(iterate.positions - before));
  }

  state.positions = iterate.positions;
  state.velocities = unflatten(iterate.velocity);
  state.limit_multipliers = iterate.multipliers;
  count_contacts(model, iterate.contacts, report);
  report.limits_active = count_hexes(model, iterate.multipliers);
  Evaluation evaluation;
  evaluate(problem, state.positions, evaluation);
  report.kkt_residual = kkt_residual(problem, evaluation, state.positions,
                                     state.limit_multipliers.cwiseQuotient(problem.materials.limits), iterate.contacts);
  remember_contacts(problem, iterate.contacts, state);
  return report;
}

}  // namespace umax
