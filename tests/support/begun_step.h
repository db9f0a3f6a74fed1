// A model, a state of it and what the step from there solves: for tests of a step's parts.
#pragma once

#include <utility>

#include "core/problem/step_problem.h"

namespace umax::test {

struct BegunStep {
  Model model;
  StepOptions options;
  State state;
  ContactGeometry geometry = make_contact_geometry(model);
  StepProblem problem = begin_step(model, options, plan_linear_solvers(model, options.solver), geometry, state);

  BegunStep(Model of, State from, StepOptions with = {})
      : model(std::move(of)), options(std::move(with)), state(std::move(from)) {}
  explicit BegunStep(const Model& of) : BegunStep(of, rest_state(of)) {}
  // the problem knows where the others are
  BegunStep(const BegunStep&) = delete;
  BegunStep& operator=(const BegunStep&) = delete;
};

}  // namespace umax::test
