// Semi-smooth Newton steps on the natural map of frictional contacts (core/step/contact_forces.h).
#pragma once

#include "core/step/contact_problem.h"

namespace umax {

/// A few Newton steps, as far as they leave less than there was: the sets of contacts that push and slide settle on the way.
/// Was one kept? tolerance: of what_is_left().
bool try_newton(const ContactProblem& problem, double tolerance, ContactState& state);

}  // namespace umax
