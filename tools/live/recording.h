// What a live session leaves on the disk: its last states, saved sessions, and sessions as runs that can be rendered.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tools/live/session.h"
#include "tools/system/locked_folder.h"

namespace umax {

/// Owns the lock on a live folder while it lives.
class Recording {
 public:
  /// Throws what LockedFolder throws. keep: states that stay on the disk. States that are there are removed with
  /// ExistingFolder::overwrite; saved sessions stay.
  Recording(const std::filesystem::path& path, ExistingFolder existing, int keep);

  const std::filesystem::path& path() const { return folder_.path(); }
  int most_frames() const { return keep_; }
  int first_frame() const { return first_; }  // that is kept; 0: none
  int last_frame() const { return last_; }

  /// Keeps the state of a frame, and drops those of later frames and the oldest beyond `keep`. Throws Error
  /// (cannot_create, io_error).
  void keep(int frame, const State& state, const Digest& digest);

  /// Drops the states behind a frame.
  void cut(int frame);

  /// The state of a frame that is kept. Throws Error (bad_data, io_error) when its file has been damaged.
  std::optional<State> state(int frame) const;

  /// A name that nothing in the folder has: "session-01".
  std::string new_name() const;

 private:
  std::filesystem::path file_of(int frame) const;

  LockedFolder folder_;
  int keep_ = 1, first_ = 0, last_ = 0;
};

/// Throws what Recording would throw for a folder that is there already. Changes nothing.
void check_live_folder(const std::filesystem::path& path, ExistingFolder existing);

/// Writes NAME.toml, and NAME.pulls where something was pulled; returns the path of the scene. Throws Error
/// (cannot_create, io_error).
std::filesystem::path save_session(const Session& session, const Recording& recording);

/// What render_session() made.
struct SessionRun {
  std::filesystem::path scene;  // as save_session()
  std::filesystem::path run;    // empty: states have been dropped already, the scene has to be simulated
  int frames = 0;
};

/// Saves the session, and puts it into a run's folder beside that, as umax simulate would, where all its states are kept.
SessionRun save_run(const Session& session, const Recording& recording);

}  // namespace umax
