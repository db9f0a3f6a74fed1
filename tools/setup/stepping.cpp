#include "tools/setup/stepping.h"

#include <cmath>

namespace umax {

Stepping begin_stepping(const Simulation& simulation) {
  Stepping stepping{.simulation = &simulation, .own = {}, .keyed = {}, .options = simulation.options, .workspace = {}};
  if (has_keyed_mass_or_friction(simulation.model)) {
    stepping.own = std::make_unique<Model>(simulation.model);
    stepping.keyed = stepping.own.get();
  }
  return stepping;
}

Stepping begin_stepping_in_place(Simulation& simulation) {
  return {
      .simulation = &simulation, .own = {}, .keyed = &simulation.model, .options = simulation.options, .workspace = {}};
}

void forget_model(Stepping& stepping) {
  const std::vector<Model::BodyRange>& bodies = stepping.model().bodies;
  const bool is_copied = bodies.size() > 1 || bodies.front().pins;  // by islands, by pins
  if (is_copied) stepping.workspace.reset();
}

StepReport advance(Stepping& stepping, const std::vector<Pull>& pulls, State& state) {
  const Simulation& simulation = *stepping.simulation;
  const double end = state.time + stepping.options.time_step;
  if (stepping.keyed && bring_to(*stepping.keyed, end)) stepping.workspace.reset();
  if (!stepping.workspace) stepping.workspace = std::make_unique<Workspace>(stepping.model());
  stepping.options.gravity = simulation.scene.clip.gravity.at(end);
  stepping.options.pulls = pulls;
  stepping.options.solver.linear = simulation.options.solver.linear;
  if (!pulls.empty() && stepping.options.solver.linear == LinearSolver::automatic)
    stepping.options.solver.linear = LinearSolver::direct;  // the others know no springs
  return step(stepping.model(), stepping.options, *stepping.workspace, state);
}

Preroll preroll(Stepping& stepping, const std::function<void()>& before_step, State& state) {
  const double time_step = stepping.options.time_step;
  Preroll done{.steps = (long long)(std::ceil(stepping.simulation->scene.clip.preroll / time_step - 1e-9))};
  if (done.steps == 0) return done;
  state.time = -double(done.steps) * time_step;
  for (long long i = 0; i < done.steps; ++i) {
    before_step();
    done.not_converged += advance(stepping, {}, state).status != StepStatus::converged;
  }
  state.time = 0;
  state.step = 0;
  return done;
}

const std::vector<Pull>& recorded_pulls(const Simulation& simulation, const State& state) {
  static const std::vector<Pull> none;
  if (state.time < -0.5 * simulation.options.time_step) return none;  // clip.preroll
  const auto found = simulation.pulls.find(state.step);
  return found == simulation.pulls.end() ? none : found->second;
}

}  // namespace umax
