#include "core/problem/linear_plan.h"

#include <algorithm>

#include "core/model/pins.h"

namespace umax {
namespace {

// From how many hexes on multigrids are faster than factors. What bodies that touch do to each other is known to factors and
// has to be found out on multigrids, contact by contact: there it takes a larger body.
constexpr double alone = 600, together = 2000;

std::optional<ErrorText> multigrid_obstacle(const std::vector<LinearTraits>& bodies, const SolverOptions& solver) {
  const std::string direct = "or leave solver.linear out";
  if (solver.method != SolverMethod::exact)
    return ErrorText{"solver.method", "is the paper's, which has linear systems of its own", "", "leave it out"};
  for (const LinearTraits& body : bodies)
    if (!body.is_regular)
      return ErrorText{"body." + body.name + ".cage", "is no regular lattice, which multigrid needs", "",
                       "use a cage of cells, " + direct};
  for (const LinearTraits& body : bodies)
    if (body.has_springs)
      return ErrorText{"body." + body.name + ".pin", "holds points by springs, which multigrid is slow with", "",
                       "pin all points of whole hexes, " + direct};
  if (solver.energy != EnergyMeasure::true_energy || solver.jacobian != LimitJacobian::exact)
    return ErrorText{"solver.energy, solver.jacobian", "are the paper's, which multigrid does not know", "",
                     "leave them out, " + direct};
  if (solver.rotation != RotationEstimate::centre)
    return ErrorText{"solver.rotation", "is not the centre's, which multigrid needs", "", "leave it out, " + direct};
  return std::nullopt;
}

bool wants_multigrid(const std::vector<LinearTraits>& bodies, const SolverOptions& solver) {
  if (solver.linear != LinearSolver::automatic) return solver.linear == LinearSolver::multigrid;
  const double least = bodies.size() == 1 ? alone : together;
  return std::any_of(bodies.begin(), bodies.end(), [&](const LinearTraits& body) { return body.hexes >= least; });
}

}  // namespace

LinearPlan plan_linear_solvers(const std::vector<LinearTraits>& bodies, const SolverOptions& solver) {
  LinearPlan plan{.bodies = {}, .against_multigrid = multigrid_obstacle(bodies, solver)};
  const bool multigrid = !plan.against_multigrid && wants_multigrid(bodies, solver);
  plan.bodies.assign(bodies.size(), multigrid ? LinearBackend::multigrid : LinearBackend::direct);
  return plan;
}

LinearPlan plan_linear_solvers(const Model& model, const SolverOptions& solver) {
  std::vector<LinearTraits> bodies;
  for (const Model::BodyRange& body : model.bodies) {
    bodies.push_back({.name = body.name,
                      .hexes = double(body.num_hexes),
                      .is_regular = body.cells.rows() > 0,
                      .has_springs = body.pins && body.pins->ever_has_springs()});
  }
  return plan_linear_solvers(bodies, solver);
}

void require_solvable(const LinearPlan& plan, const SolverOptions& solver) {
  if (solver.method != SolverMethod::exact || solver.linear != LinearSolver::multigrid) return;
  if (plan.against_multigrid) throw Error(Fault::bad_data, *plan.against_multigrid);
}

}  // namespace umax
