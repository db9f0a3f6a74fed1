// The linear system of one Newton iteration: inertia, damping, elasticity, limits and, in the safety net, contacts.
#pragma once

#include <vector>

#include "core/contact_law.h"
#include "core/iterate.h"
#include "core/limit_law.h"
#include "core/workspace.h"

namespace umax {

/// What limits and contacts add at an iterate.
struct Linearisation {
  std::vector<LimitTerms> limits;      // #L
  std::vector<ContactTerms> contacts;  // one per contact of the iterate, or none where they are solved for apart
};

/// Terms of every limit, hard ones with the penalty rho = relative_penalty U_max [J].
std::vector<LimitTerms> limit_terms(const StepProblem& problem, const Iterate& iterate, double relative_penalty);

/// Factors the Hessian at the iterate: exact elasticity if that is positive definite, else with warped stiffness in the
/// hexes that are not so by themselves: from then on that is what is tried. Returns the number of factorisations.
int factorize(const StepProblem& problem, const Linearisation& at, Iterate& iterate, Workspace::Data& workspace);

/// Gradient [N] of inertia, damping, elasticity, gravity, limits and contacts: 3 #N, fixed nodes zero.
VectorXd gradient(const StepProblem& problem, const Iterate& iterate, const Linearisation& at);

}  // namespace umax
