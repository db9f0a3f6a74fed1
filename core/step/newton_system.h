// The linear system of one Newton iteration: inertia, damping, elasticity, limits and, in the safety net, contacts.
#pragma once

#include <vector>

#include "core/contact/contact_law.h"
#include "core/element/limit_law.h"
#include "core/problem/iterate.h"
#include "core/step/workspace.h"

namespace umax {

/// What limits and contacts add at an iterate.
struct Linearisation {
  std::vector<LimitTerms> limits;      // #L
  std::vector<ContactTerms> contacts;  // one per contact of the iterate, or none where they are solved for apart
};

/// Terms of every limit, hard ones with the penalty rho = relative_penalty U_max [J].
std::vector<LimitTerms> limit_terms(const StepProblem& problem, const Iterate& iterate, double relative_penalty);

/// Factors each body's Hessian at the iterate: exact elasticity if that is positive definite, else with warped stiffness in
/// the hexes that are not so by themselves: from then on that is what is tried. Returns the number of factorisations of
/// the body that took most.
int factorize(const StepProblem& problem, const Linearisation& at, Iterate& iterate, Workspace::Data& workspace);

/// The multigrid's counterpart, with warped stiffness. further: terms beside those of limits and contacts, after them.
void set_up_multigrid(const StepProblem& problem, const Linearisation& at, const Iterate& iterate,
                      const std::vector<RankOneTerm>& further, Workspace::Data& workspace);

/// A spring of this stiffness [N/m] along a direction (of length 1) at a contact's support, as a term.
RankOneTerm spring_term(const Support& support, const Vector3d& direction, double stiffness);

/// A Newton step, and what the solver tells of limits.
struct NewtonStep {
  VectorXd step;          // 3 #N [m]
  VectorXd limit_change;  // #L [J] G . step of limits with a rank-one term, 0 of others
};

/// The solution of the system that set_up_multigrid() saw, as far as it is solved.
NewtonStep multigrid_step(const Model& model, const Linearisation& at, const MultigridSystem& system);

/// -A^-1 slope with the linear solver that is planned for the model. Work is added to the report.
VectorXd newton_step(const StepProblem& problem, const Linearisation& at, const VectorXd& slope, double accuracy,
                     Iterate& iterate, Workspace::Data& workspace, StepReport& report);

/// Gradient [N] of inertia, damping, elasticity, gravity, limits and contacts: 3 #N, fixed nodes zero.
VectorXd gradient(const StepProblem& problem, const Iterate& iterate, const Linearisation& at);

}  // namespace umax
