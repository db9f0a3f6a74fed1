// A small scene that live sessions are tested with, and what they leave, run again.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene_file.h"
#include "tests/support/temporary_folder.h"
#include "tools/live/recording.h"

namespace umax::test {

/// A block of 8 hexes a little above the ground.
inline std::string live_scene_text(const std::string& body = {}, const std::string& clip = {}) {
  return "[clip]\nframes = 20\nsubsteps = 2\n" + clip +
         "[body.block]\nmesh = \"" UMAX_SOURCE_DIR
         "/tests/support/block.obj\"\nposition = [0, 0.24, 0]\nrotation = [10, 0, 20]\n"
         "cage.cells = [2, 2, 2]\nmaterial.young = \"20 kPa\"\nlimit.stretch = \"10 %\"\n" +
         body + "[obstacle.ground]\nshape = \"plane\"\n";
}

inline Scene live_scene(const TemporaryFolder& folder, const std::string& body = {}, const std::string& clip = {}) {
  make_file(folder / "block.toml", live_scene_text(body, clip));
  return load_scene((folder / "block.toml").string(), {});
}

/// The number of the session's key with this path.
inline std::size_t key_of(const Session& session, const std::string& path) {
  for (std::size_t i = 0; i < session.keys.size(); ++i)
    if (session.keys[i].path == path) return i;
  throw std::out_of_range(path);
}

/// The bytes of a state, whatever model it is of.
inline std::string bytes_of(const State& state) {
  return encode_state(state, Digest(64, '0'));
}

/// The states of all steps of a scene, from the first on, as umax simulate makes them.
inline std::vector<std::string> simulated(const Scene& scene, long long steps) {
  const Simulation simulation = set_up(scene);
  Stepping stepping = begin_stepping(simulation);
  State state = rest_state(simulation.model);
  std::vector<std::string> states;
  for (long long i = 0; i < steps; ++i) {
    advance(stepping, recorded_pulls(simulation, state), state);
    states.push_back(bytes_of(state));
  }
  return states;
}

/// Steps a session and takes its states.
inline void step_often(Session& session, int steps, std::vector<std::string>& states) {
  for (int i = 0; i < steps; ++i) {
    step(session);
    states.push_back(bytes_of(session.state));
  }
}

/// Saved under the folder, read, and simulated again.
inline std::vector<std::string> replayed(const Session& session, const TemporaryFolder& folder, long long steps) {
  const Recording recording(folder / "live", ExistingFolder::refuse, 100);
  return simulated(load_scene(save_session(session, recording).string(), {}), steps);
}

}  // namespace umax::test
