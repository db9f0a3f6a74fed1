// Contacts within one step: how far they have moved, what they ask of the solvers, and what the next step is told.
#pragma once

#include <vector>

#include "core/contact/contact_support.h"
#include "core/contact/gauss_seidel.h"
#include "core/problem/step_problem.h"

namespace umax {

/// Motion [m] of a contact point relative to the obstacle during the step that ends at the positions.
Vector3d relative_motion(const StepProblem& problem, const Points& positions, const Contact& contact);

/// Contacts as the first rows of a complementarity problem at the positions, whose w are motions [m] relative to the
/// obstacles during the step: those so far, and what the step from the positions adds to them.
struct ContactRows {
  std::vector<ContactRow> rows;
  VectorXd motions;  // 3 #C [m] so far
};
ContactRows contact_rows(const StepProblem& problem, const Points& positions, const std::vector<Contact>& contacts);

/// Penalty [N/m] of an augmented Lagrangian on a contact: much stiffer than the hex that it holds.
double contact_penalty(const StepProblem& problem, const Contact& contact);

/// Vertices that are inside a body at the positions, by more than tolerances explain, keep where they were last apart; the
/// positions count for all others. contacts: complete there.
void remember_apart(const Model& model, const std::vector<Contact>& contacts, const Points& positions,
                    LastApart& apart);

/// Depth [m] of the deepest contact of a working set, 0 where all are open.
double deepest(const std::vector<Contact>& contacts);

/// The impulses that the next step starts from: force times the time step, so that they suit steps of any size. And the
/// vertices that started deep: bodies on their way out of each other need not push.
void remember_contacts(const StepProblem& problem, const std::vector<Contact>& contacts, State& state);

/// Contacts of the last step that carried an impulse, placed at the given positions.
std::vector<Contact> recall_contacts(const StepProblem& problem, const State& state, const Points& positions);

}  // namespace umax
