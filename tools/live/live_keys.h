// What can be turned while bodies move: the keys of a scene that take keyframes and act from one step to the next.
#pragma once

#include <string>
#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

enum class LiveKind { limit, young, density, damping_mass, damping_stiffness, friction, gravity };

/// [-] A limit of this stretch is none: what holds together comes nowhere near it. Limits that a scene lacks begin there.
inline constexpr double no_limit = 10;

struct LiveKey {
  std::string path;  // as the scene has it: "body.figure.limit.stretch"
  LiveKind kind = LiveKind::limit;
  int body = -1;                           // of the scene; -1: of all
  EnergyPart part = EnergyPart::whole;     // of limits
  LimitUnit unit = LimitUnit::stretch;     // likewise
  Vector3d direction{0, -1, 0};            // of gravity, whose strength is turned
  double least = 0, most = 0;              // that a message may set, in the scene's unit
  double slider_low = 0, slider_high = 0;  // where its slider begins (beside 0, where that is allowed) and ends
  bool may_be_none = false;                // a limit that the scene lacks: no_limit takes it away again
  bool is_animated = false;                // the scene has keys of its own for it: it cannot be turned
  double value_at(const Scene& scene, double time) const;
};

/// The scene with a limit of no_limit on every body that has none on its whole energy, so that it can be turned down. The
/// paper's method, which has no use for limits that nothing reaches, is left as it is.
Scene with_turnable_limits(Scene scene);

/// All keys of a scene's bodies, whatever limits they have, and of gravity.
std::vector<LiveKey> live_keys(const Scene& scene);

/// Makes the key hold a value from a time [s] on, in the scene and in the model alike. Later keys than that are dropped.
void hold_from(const LiveKey& key, double time, double value, Simulation& simulation);

/// Drops what is held from a time [s] on.
void drop_from(const LiveKey& key, double time, Simulation& simulation);

/// What handles move is counted together: first the scene's obstacles, then its pins.
std::size_t count_handles(const Scene& scene);

/// Whether it can be moved: an obstacle that is no plane, or a pin, that the scene does not animate.
bool can_place(const Scene& original, std::size_t handle);

/// [m] where it is at a time [s]: an obstacle's place, the middle of a pin's points.
Vector3d place_at(const Simulation& simulation, std::size_t handle, double time);

/// Puts it to a place [m] from a time [s] on, in the scene and in the model alike; drop_places_from() undoes that.
void place_from(std::size_t handle, double time, const Vector3d& place, Simulation& simulation);
void drop_places_from(const Scene& original, double time, Simulation& simulation);

/// Where a limit that is to become `goal` stands after a step of `time_step` [s]: it rises at once, and falls by at most
/// half a stretch in a second, however it is given.
double limit_after_step(const LiveKey& key, const Simulation& simulation, double now, double goal, double time,
                        double time_step);

}  // namespace umax
