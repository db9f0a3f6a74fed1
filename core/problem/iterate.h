// The exact method's unknowns as they are improved, and how far they are from the step's solution.
#pragma once

#include <vector>

#include "core/element/limit_law.h"
#include "core/problem/evaluation.h"
#include "core/problem/step_contacts.h"

namespace umax {

/// [-] Residual, in tolerances, of an iterate whose successor may be the step's solution.
inline constexpr double near_solution = 3;

/// Are forces in balance at an iterate with this residual [-], so that only limits and contacts may miss theirs?
inline bool is_balanced(double kkt_residual, double tolerance) {
  return kkt_residual <= tolerance;
}

/// What a body's matrix was factored for.
struct FactoredAt {
  Points positions;                // of its nodes [m]; empty: it was not, in this step
  std::vector<LimitTerms> limits;  // of its hexes
};

struct Iterate {
  Points positions;               // #N x 3 [m]
  LastApart apart;                // by the step's start and the iterates
  VectorXd multipliers;           // #L force-level [J]
  std::vector<char> released;     // #L limits that are left out of the next linearisation
  std::vector<Contact> contacts;  // working set
  Evaluation evaluation;          // at positions
  double last_move = 0;           // [cells] largest node displacement of the last iteration
  std::vector<double> residuals;  // [-] KKT, of the iterates so far and of this one as soon as it is assessed
  std::vector<char> indefinite;   // per body: its exact Hessian was not positive definite at one of the last iterations
  std::vector<FactoredAt> factored;  // per body
};

/// What decides whether the iterate is the solution.
struct Quality {
  double kkt = 0;
  double max_ratio = 0;        // [-] U/U_max of hard limits
  double complementarity = 0;  // [-] |U/U_max - 1| where a multiplier pushes
  double depth = 0;            // deepest working-set contact, in penetration tolerances
  double limit_work = 0;       // [J] that multipliers could do between here and where the limits hold exactly
};

/// Where nodes go by inertia, and where nothing holds their body up by gravity and forces from outside; the last step's multipliers and
/// contact forces.
Iterate predict(const StepProblem& problem, const State& state);

/// Every body undeformed where the predictor has it: its centre of mass and best-fitting rotation; no multipliers.
Iterate predict_undeformed(const StepProblem& problem, const State& state);

/// Brings contacts to the iterate's positions and adds those that are missing; their number. keeps_normals: those of
/// obstacles, for iterations that would otherwise flip for ever between two faces at an edge.
int find_contacts(const StepProblem& problem, bool keeps_normals, Iterate& iterate);

/// Vertices that a step would push in too deep join the contacts, as they are at the iterate: into obstacles, and into bodies
/// as far as the step will go. Returns their number.
int add_linearised_contacts(const StepProblem& problem, const VectorXd& step, bool with_bodies, Iterate& iterate);

/// lambda/U_max, or the barrier's slope: #L factors [-] on G in the gradient of the Lagrangian.
VectorXd limit_factors(const StepProblem& problem, const Iterate& iterate);

Quality assess(const StepProblem& problem, const Iterate& iterate);

/// All constraints, stationarity and the last move within the solver's tolerance.
bool is_solution(const StepProblem& problem, const Quality& quality, const Iterate& iterate);

/// Is the first guess, which is a solution to the solver's tolerance, better than that, or does nothing move? Where bodies
/// go on by inertia for a few steps before forces that are missing count, they are late, and late forces feed a swing.
bool is_exact_guess(const StepProblem& problem, const Quality& quality, const Iterate& iterate);

/// Reports the iterate to StepOptions::on_iteration.
void report_iteration(const StepProblem& problem, int iteration, const Quality& quality, const Iterate& iterate);

}  // namespace umax
