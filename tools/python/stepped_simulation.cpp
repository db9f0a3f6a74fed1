#include "tools/python/stepped_simulation.h"

#include <fmt/format.h>

#include <utility>

#include "tools/setup/body_contact.h"

namespace umax {

SteppedSimulation::SteppedSimulation(const Scene& scene, const std::function<void()>& on_iteration)
    : simulation_(set_up(scene)), stepping_(begin_stepping(simulation_)), warnings_(simulation_.warnings) {
  if (!simulation_.scene.clip.allow_overlap) require_clear_start(simulation_.model);
  stepping_.options.on_iteration = [on_iteration](const IterationReport&) { on_iteration(); };
  state_ = rest_state(simulation_.model);
  const Preroll done = preroll(stepping_, on_iteration, state_);
  if (done.not_converged > 0)
    warnings_.push_back(fmt::format("{} of {} steps of clip.preroll did not converge", done.not_converged, done.steps));
  initial_ = state_;
}

StepReport SteppedSimulation::step(const Points& forces) {
  stepping_.options.forces = forces;
  const StepReport report = advance(stepping_, recorded_pulls(simulation_, state_), state_);
  update_followed();
  return report;
}

void SteppedSimulation::restore(const State& state) {
  state_ = state;
  update_followed();
}

std::shared_ptr<const Points> SteppedSimulation::follow(std::size_t body, BodyPoints quantity) {
  for (const Followed& followed : followed_)
    if (followed.body == body && followed.quantity == quantity)
      if (std::shared_ptr<Points> values = followed.values.lock()) return values;
  auto values = std::make_shared<Points>(points_of_body(simulation_, state_, body, quantity));
  followed_.push_back({body, quantity, values});
  return values;
}

void SteppedSimulation::update_followed() {
  std::erase_if(followed_, [](const Followed& followed) { return followed.values.expired(); });
  for (const Followed& followed : followed_)  // into the same memory: there are as many of them as before
    if (const std::shared_ptr<Points> values = followed.values.lock())
      values->noalias() = points_of_body(simulation_, state_, followed.body, followed.quantity);
}

}  // namespace umax
