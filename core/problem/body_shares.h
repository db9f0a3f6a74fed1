// How far bodies go along a step of an iteration, so that none passes another unseen: core/contact/encounters.h.
#pragma once

#include "core/problem/iterate.h"

namespace umax {

/// Moves the iterate from the step's start towards where it is, to where bodies first meet: those that move far against
/// each other could be through each other at once.
void approach(const StepProblem& problem, Iterate& iterate);

/// Share of a step of 3 #N [m] from the iterate on which no bodies move past each other unseen, at most 1.
double felt_share(const StepProblem& problem, const Iterate& iterate, const VectorXd& step);

/// Shares of the step above 1 (#B, more than what a body's matrix asks for), as far as no bodies move past each other
/// unseen; those up to 1 as they are.
VectorXd as_far_as_felt(const StepProblem& problem, const Iterate& iterate, const VectorXd& step, VectorXd shares);

/// Share of the step that each body takes: #B. As much as what is linear in it holds (step_fractions()) and as is felt; bodies
/// that push each other go on alike, others do not hold them up.
VectorXd body_shares(const StepProblem& problem, const Iterate& iterate, const VectorXd& step);

/// Multiplies each body's part of the step by its share.
void scale_bodies(const Model& model, const VectorXd& shares, VectorXd& step);

}  // namespace umax
