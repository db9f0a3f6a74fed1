// A simulation as Python holds it: one thread of Python may use it at a time.
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "core/base/error.h"
#include "tools/python/editable_scene.h"
#include "tools/python/stepped_simulation.h"

namespace umax {

struct SharedSimulation {
  std::unique_ptr<const EditableScene> scene;  // that it was made of
  std::unique_ptr<SteppedSimulation> stepped;
  std::optional<int> threads;  // none: all cores
  std::atomic<bool> is_busy = false;

  /// Held by who uses the simulation. Throws Error (try_again) while another does.
  class Busy {
   public:
    explicit Busy(SharedSimulation& shared) : shared_(shared) {
      if (shared_.is_busy.exchange(true))
        throw Error(Fault::try_again, {.where = "Simulation",
                                       .what = "is in the middle of a step",
                                       .value = "",
                                       .remedy = "use it in one thread at a time, or make one for each"});
    }
    ~Busy() { shared_.is_busy = false; }
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;

   private:
    SharedSimulation& shared_;
  };
};

}  // namespace umax
