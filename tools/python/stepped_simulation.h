// A simulation that a script steps, in memory: the same steps as those of a run, and arrays that follow them.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "tools/python/body_values.h"
#include "tools/setup/stepping.h"

namespace umax {

class SteppedSimulation {
 public:
  /// Sets the scene up and leads it to its first frame. on_iteration: called often during long work; what it throws ends
  /// that. Throws what set_up() and require_clear_start() throw.
  SteppedSimulation(const Scene& scene, const std::function<void()>& on_iteration);
  SteppedSimulation(const SteppedSimulation&) = delete;
  SteppedSimulation& operator=(const SteppedSimulation&) = delete;

  Simulation& simulation() { return simulation_; }
  const State& initial_state() const { return initial_; }
  const State& state() const { return state_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// One time step. forces: StepOptions::forces. Throws what core's step() throws; the state is then as before.
  StepReport step(const Points& forces);

  /// Goes back (or on) to a state of this model.
  void restore(const State& state);

  /// Values of a body that are those of the state after every step, as long as somebody holds them.
  std::shared_ptr<const Points> follow(std::size_t body, BodyPoints quantity);

 private:
  struct Followed {
    std::size_t body = 0;
    BodyPoints quantity = BodyPoints::positions;
    std::weak_ptr<Points> values;
  };
  void update_followed();

  Simulation simulation_;
  Stepping stepping_;
  State initial_, state_;
  std::vector<Followed> followed_;
  std::vector<std::string> warnings_;
};

}  // namespace umax
