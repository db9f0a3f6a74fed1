#include "core/step/direct_subproblem.h"

#include <algorithm>
#include <utility>

#include "core/step/delassus.h"

namespace umax {
namespace {

constexpr int max_contact_rounds = 10;        // detections per factorisation
constexpr int reordering_nodes = 1500;        // of a cage: fewer are not worth it
constexpr double reordering_margin = 1;       // [cells]
constexpr double most_reordered_share = 0.2;  // of the nodes, and no more than
constexpr double most_reordered = 800;        // nodes: their part of the factor is dense

// contacts against W, whose unknowns are forces [N], and w the motions at the end of the step that they change
ComplementarityProblem contact_problem(const StepProblem& problem, const Iterate& iterate, const VectorXd& free_step,
                                       const MatrixXd& W) {
  auto [rows, motions] = contact_rows(problem, iterate.positions, iterate.contacts);
  for (std::size_t i = 0; i < rows.size(); ++i)
    motions.segment<3>(3 * Eigen::Index(i)) += contact_motion(*problem.model, iterate.contacts[i], free_step);
  return {.W = W, .q = std::move(motions), .contacts = std::move(rows)};
}

// dx = -A^-1 grad + A^-1 J^T f; vertices that dx would push in too deep join the working set against the same factor
VectorXd solve_step(const StepProblem& problem, const SparseCholesky& cholesky, const VectorXd& grad, Iterate& iterate,
                    StepReport& report) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  VectorXd free_step = -grad;
  cholesky.solve(free_step);
  VectorXd step = free_step;
  Delassus delassus;
  for (int round = 0; round < max_contact_rounds; ++round) {
    extend(model, cholesky, iterate.contacts, delassus);
    if (!iterate.contacts.empty()) {
      VectorXd force(3 * Eigen::Index(iterate.contacts.size()));
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
        force.segment<3>(3 * Eigen::Index(i)) = iterate.contacts[i].force;
      report.linear_iterations +=
          gauss_seidel(contact_problem(problem, iterate, free_step, delassus.W),
                       {.max_sweeps = solver.max_sweeps, .tolerance = std::min(1e-6, 1e-2 * solver.tolerance)}, force)
              .sweeps;
      VectorXd push = VectorXd::Zero(step.size());
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i) {
        iterate.contacts[i].force = force.segment<3>(3 * Eigen::Index(i));
        spread(model, iterate.contacts[i], force.segment<3>(3 * Eigen::Index(i)), push);
      }
      clear_fixed(model, push);
      cholesky.solve(push);
      step = free_step + push;
    }
    if (add_linearised_contacts(problem, step, iterate) == 0) break;
  }
  return step;
}

// G . step of the limits that are active [J]
VectorXd limit_change(const StepProblem& problem, const Linearisation& at, const VectorXd& step,
                      const Iterate& iterate) {
  const Model& model = *problem.model;
  VectorXd change = VectorXd::Zero(problem.materials.limits.size());
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l)
    if (at.limits[l].rank_one > 0)
      for (int n = 0; n < 8; ++n)
        change[l] += iterate.evaluation.limit_gradient(model, l).segment<3>(3 * n).dot(
            step.segment<3>(3 * model.hexes(model.limits[l].hex, n)));
  return change;
}

// Nodes that contacts of this step are likely to push: eliminated last, they make every contact's compliance cheap.
// None in small cages, where analysing the pattern for each new set costs more, nor where there are too many.
std::vector<int> nodes_near_obstacles(const StepProblem& problem, const Iterate& iterate) {
  const Model& model = *problem.model;
  std::vector<int> nodes;
  if (model.num_nodes() < reordering_nodes) return nodes;
  std::vector<char> near(model.num_nodes(), 0);
  for (const int hex : hexes_near_obstacles(problem.contact, iterate.positions, reordering_margin))
    for (int n = 0; n < 8; ++n) near[model.hexes(hex, n)] = 1;
  for (const Contact& contact : iterate.contacts)
    for_each_node(model, contact, [&](int node, double) { near[node] = 1; });
  for (int node = 0; node < int(near.size()); ++node)
    if (near[node]) nodes.push_back(node);
  if (double(nodes.size()) > std::min(most_reordered, most_reordered_share * double(model.num_nodes()))) nodes.clear();
  return nodes;
}

}  // namespace

void prepare_direct(const StepProblem& problem, const Iterate& iterate, Workspace::Data& workspace) {
  eliminate_last(*problem.model, nodes_near_obstacles(problem, iterate), workspace);
}

NewtonStep minimise_direct(const StepProblem& problem, const Linearisation& at, const VectorXd& slope, Iterate& iterate,
                           Workspace::Data& workspace, StepReport& report) {
  report.factorisations += factorize(problem, at, iterate, workspace);
  NewtonStep newton;
  newton.step = solve_step(problem, workspace.cholesky, slope, iterate, report);
  newton.limit_change = limit_change(problem, at, newton.step, iterate);
  return newton;
}

}  // namespace umax
