// A live session: a simulation, and what was changed and pulled while it ran, so that it can be saved and run again.
//
// A change is a key that holds from a quarter of the step on in which it first acts. Restarting keeps the values of the
// moment: they hold from the first step on.
#pragma once

#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tools/live/live_keys.h"
#include "tools/run/steps_csv.h"
#include "tools/setup/stepping.h"

namespace umax {

/// A point of a surface that is held by a spring.
struct Grab {
  int body = 0;
  int vertex = 0;          // of its mesh
  Vector3d goal{0, 0, 0};  // [m] where it is wanted
};

/// A cage of more hexes is no longer live.
inline constexpr int most_live_cells = 20000;

struct Session {
  Simulation simulation;    // its scene and model have all changes so far
  std::mutex other_meshes;  // locked while set_cells() replaces the simulation, and by threads that read its meshes
  Scene original;           // as it was set up
  std::vector<LiveKey> keys;
  std::vector<double> goals;  // of each key: where a limit that falls is heading, else what it has
  Stepping stepping;          // of `simulation`: a session is not moved
  State state;
  std::optional<Grab> grab;
  std::vector<std::optional<Vector3d>> places;  // [m] that obstacles, and behind them pins, are on the way to
  RecordedPulls pulls;
  std::deque<StepRow> rows;               // of the last steps
  std::size_t most_rows = 100000;         // that are kept
  long long steps_not_converged = 0;      // since the start
  StepReport last;                        // of the step that led to the state
  std::vector<std::optional<int>> cells;  // that bodies have been given by set_cells()

  explicit Session(const Scene& scene);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  int substeps() const { return simulation.scene.clip.substeps; }
  /// The frame that the state belongs to, or that it is on the way to.
  int frame() const { return int((state.step + substeps() - 1) / substeps()) + 1; }
  bool at_frame() const { return state.step % substeps() == 0; }
};

/// What a key has in the next step.
double value_now(const Session& session, std::size_t key);

/// Sets a key from the next step on; a limit that falls does so gradually. False: there is no such key, its value is out
/// of range, or the scene animates it.
bool set_key(Session& session, std::size_t key, double value);

/// Whether the scene's solver knows springs.
bool can_grab(const Session& session);

/// Holds a vertex of a body at a place, or moves the place. False: there is no such vertex, the place is not finite, or
/// the scene's solver knows no springs.
bool grab(Session& session, const Grab& grab);
void release(Session& session);

/// Moves an obstacle, or the middle of a pin, to a place, at 2 m/s at most. False: there is no such handle, it cannot be
/// moved, or the place is not finite.
bool place_handle(Session& session, std::size_t handle, const Vector3d& place);

/// Advances by a time step.
const StepReport& step(Session& session);

/// Back to the initial state, with the values of the moment.
void restart(Session& session);

/// Whether the body's cage is made by a number of cells: it brings no hexes of its own.
bool can_set_cells(const Session& session, int body);

/// Gives a body a cage of about so many hexes and goes back to the start, as restart() does. False: there is no such body, it
/// brings its hexes, or the number is out of range (1 ... most_live_cells). Throws what set_up() throws, and then nothing is
/// changed.
bool set_cells(Session& session, int body, int cells);

/// Back to a state of this session, from which it then goes on otherwise. rows beyond are dropped.
void rewind(Session& session, const State& state);

/// The scene that runs as the session did up to its last whole frame, and the pulls beside it; the scene names their file
/// (none: empty) and its SHA-256.
struct SessionFiles {
  Scene scene;
  std::string pulls;  // bytes
};
SessionFiles session_files(const Session& session, const std::string& pulls_name);

/// The lines of a scene file that give the keys the values of the moment: those that have been changed.
std::string scene_lines(const Session& session);

}  // namespace umax
