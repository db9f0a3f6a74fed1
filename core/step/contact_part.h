// Some of the contacts of a problem, as a problem of their own. Of the contacts that a step looks at most do not push: sweeps
// over those that do find forces in half the time, and a look at all others now and then tells which of them have to join.
#pragma once

#include <vector>

#include "core/step/contact_problem.h"

namespace umax {

class ContactPart {
 public:
  /// Of these contacts, ascending.
  ContactPart(const ContactProblem& all, std::vector<int> contacts);
  // the problem refers to the rest
  ContactPart(const ContactPart&) = delete;
  ContactPart& operator=(const ContactPart&) = delete;

  const ContactProblem& problem() const { return problem_; }
  /// The state of these contacts where all have this one.
  ContactState state_of(const ContactState& all) const;
  /// The state of all contacts where these have this one, and the others no forces.
  ContactState state_of_all(const ContactState& state) const;

 private:
  const ContactProblem& all_;
  std::vector<int> contacts_;
  Delassus delassus_;
  std::vector<ContactRow> rows_;
  VectorXd q_;
  ContactProblem problem_;
};

}  // namespace umax
