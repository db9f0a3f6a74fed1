#include "core/step/direct_subproblem.h"

#include <algorithm>
#include <utility>

#include "core/step/contact_forces.h"

namespace umax {
namespace {

constexpr int max_contact_rounds = 10;        // detections per factorisation
constexpr int max_surface_rounds = 1;         // of these, at surfaces of bodies too: the next iteration looks again
constexpr double rough_move = 0.05;           // [cells] in the last iteration
constexpr double most_held = 1e-3;            // [-] of contacts' compliance: 1e-2 makes more iterations
constexpr int reordering_nodes = 1500;        // of a cage: fewer are not worth it
constexpr double reordering_margin = 1;       // [cells]
constexpr double most_reordered_share = 0.2;  // of the nodes, and no more than
constexpr double most_reordered = 800;        // nodes: their part of the factor is dense

bool bodies_may_touch(const StepProblem& problem) {
  return problem.contact.geometry->touchable.any();
}

// Do bodies that may touch still move so far that their contacts will be others in the next iteration? Forces that were
// found to many digits are of no use then, nor is a look at what the step would push into what.
bool is_rough(const StepProblem& problem, const Iterate& iterate) {
  return iterate.last_move > rough_move && bodies_may_touch(problem);
}

// of contact forces: no more than the tolerance, which what it hides must not pass
double proximal_weight(const StepProblem& problem) {
  return bodies_may_touch(problem) ? std::min(most_held, problem.options->solver.tolerance) : 0;
}

// dx = L^-T (-L^-1 grad + L^-1 J^T f), with the L^-1 J^T of which the contacts' compliance is made; vertices that dx would
// push in too deep join the working set against the same factor
VectorXd solve_step(const StepProblem& problem, const Workspace::Data& workspace, const VectorXd& grad,
                    Iterate& iterate, StepReport& report) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  VectorXd free = -grad;  // half of the step without contact forces
  solve_forward(model, workspace, free);
  VectorXd step;
  Delassus delassus;
  const bool rough = is_rough(problem, iterate);
  const GaussSeidelOptions sweeps{.max_sweeps = rough ? solver.max_sweeps / 10 : solver.max_sweeps,
                                  .tolerance = std::min(1e-6, 1e-2 * solver.tolerance),
                                  .is_rough = rough,
                                  .proximal_weight = proximal_weight(problem)};
  for (int round = 0; round < max_contact_rounds; ++round) {
    extend(model, workspace, iterate.contacts, delassus);
    step = free;
    if (!iterate.contacts.empty()) {
      VectorXd force(3 * Eigen::Index(iterate.contacts.size()));
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
        force.segment<3>(3 * Eigen::Index(i)) = iterate.contacts[i].force;
      auto [rows, motions] = contact_rows(problem, iterate.positions, iterate.contacts);
      motions += contact_motions(model, workspace, delassus, free);  // if they did not push
      report.linear_iterations += solve_contacts(delassus, rows, motions, sweeps, force).sweeps;
      for (std::size_t i = 0; i < iterate.contacts.size(); ++i)
        iterate.contacts[i].force = force.segment<3>(3 * Eigen::Index(i));
      add_forces(model, workspace, delassus, force, step);
    }
    solve_backward(model, workspace, step);
    if (add_linearised_contacts(problem, step, !rough && round < max_surface_rounds, iterate) == 0) break;
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

// Nodes of each body, counted from its first, that contacts of this step are likely to push: eliminated last, they make
// every contact's compliance cheap. None in small cages, where analysing the pattern for each new set costs more, nor
// where there are too many.
std::vector<std::vector<int>> nodes_near_contacts(const StepProblem& problem, const Iterate& iterate) {
  const Model& model = *problem.model;
  std::vector<std::vector<int>> nodes(model.bodies.size());
  const auto is_worth_it = [](const Model::BodyRange& body) { return body.num_nodes >= reordering_nodes; };
  if (std::none_of(model.bodies.begin(), model.bodies.end(), is_worth_it)) return nodes;
  std::vector<char> near(model.num_nodes(), 0);
  for (const int hex : hexes_near_obstacles(problem.contact, iterate.positions, reordering_margin))
    for (int n = 0; n < 8; ++n) near[model.hexes(hex, n)] = 1;
  for (const Contact& contact : iterate.contacts)
    for_each_node(model, contact, [&](int node, double) { near[node] = 1; });
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    const Model::BodyRange& body = model.bodies[b];
    if (!is_worth_it(body)) continue;
    for (int node = 0; node < body.num_nodes; ++node)
      if (near[body.first_node + node]) nodes[b].push_back(node);
    if (double(nodes[b].size()) > std::min(most_reordered, most_reordered_share * double(body.num_nodes)))
      nodes[b].clear();
  }
  return nodes;
}

}  // namespace

void prepare_direct(const StepProblem& problem, const Iterate& iterate, Workspace::Data& workspace) {
  const std::vector<std::vector<int>> nodes = nodes_near_contacts(problem, iterate);
  for (std::size_t b = 0; b < nodes.size(); ++b) eliminate_last(*problem.model, int(b), nodes[b], workspace);
}

NewtonStep minimise_direct(const StepProblem& problem, const Linearisation& at, const VectorXd& slope, Iterate& iterate,
                           Workspace::Data& workspace, StepReport& report) {
  report.factorisations += factorize(problem, at, iterate, workspace);
  NewtonStep newton;
  newton.step = solve_step(problem, workspace, slope, iterate, report);
  newton.limit_change = limit_change(problem, at, newton.step, iterate);
  return newton;
}

}  // namespace umax
