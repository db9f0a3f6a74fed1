// The folder of a run: where its files are, who may write to it, what may be replaced.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/system/locked_folder.h"

namespace umax {

/// Throws what RunFolder would throw for a folder that is there already. Changes nothing: for a look before long work.
void check_run_folder(const std::filesystem::path& path, ExistingFolder existing, FolderUse use = FolderUse::alone);

/// Those who are at work in a run's folder.
std::vector<Worker> workers_in_run(const std::filesystem::path& path);

/// Whether those who were at work in it last are gone without having tidied up.
bool is_abandoned(const std::filesystem::path& path);

/// Where exports of a run go unless the user says otherwise.
inline std::filesystem::path exports_path(const std::filesystem::path& run_folder) {
  return run_folder / "export";
}

/// Holds a run's folder while it lives.
class RunFolder {
 public:
  /// Throws what LockedFolder throws. role: for the others who share it.
  RunFolder(const std::filesystem::path& path, ExistingFolder existing, FolderUse use = FolderUse::alone,
            const std::string& role = {});

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path scene() const { return path() / "scene.toml"; }
  std::filesystem::path steps() const { return path() / "steps.csv"; }
  std::filesystem::path record() const { return path() / "run.json"; }
  std::filesystem::path log() const { return path() / "run.log"; }
  std::filesystem::path pictures() const { return path() / "pictures.json"; }
  std::filesystem::path clip() const { return path() / "clip.mp4"; }
  std::filesystem::path states() const { return path() / "states"; }
  std::filesystem::path frames() const { return path() / "frames"; }
  std::filesystem::path plots() const { return path() / "plots"; }
  std::filesystem::path exports() const { return exports_path(path()); }
  std::filesystem::path state(int frame) const;
  std::filesystem::path picture(int frame, const std::string& extension = ".png") const;

  /// Lets others in who share it, from now on.
  void share() { folder_.share(); }
  /// Throws Error (try_again) when another one has taken the folder over.
  void require_hold() const { folder_.require_hold(); }
  Presence& presence() const { return folder_.presence(); }

  /// Removes what killed programs left half-written. Nobody else may be writing.
  void remove_leftovers() const;
  /// Removes what was drawn of one frame, if anything.
  void remove_picture(int frame) const;
  /// Removes all pictures and the clip: they were made with other settings.
  void remove_pictures() const;

 private:
  LockedFolder folder_;
};

/// The error as it is to be told: of a file that is not found because the run's folder has vanished, that it has.
Error explained(const RunFolder& folder, const Error& error);

/// Removes a run and its folder, unless that holds other files too. Throws what RunFolder throws.
void remove_run(const std::filesystem::path& path);

/// Removes all runs in a folder, and the folder if nothing is left in it. Throws what RunFolder throws.
void remove_runs(const std::filesystem::path& folder);

/// Removes what a killed program left half-written in a folder.
void remove_leftovers(const std::filesystem::path& folder);

/// Removes a folder that holds nothing; does nothing to others.
void remove_if_empty(const std::filesystem::path& folder);

/// Whether a run of this program made the folder.
bool is_run_folder(const std::filesystem::path& path);

/// Frames whose state files are there, from 1 up to the first gap.
int count_states(const std::filesystem::path& run_folder);

/// Throws Error (not_found) that names the first of the frames whose state is missing.
void require_states(const std::filesystem::path& run_folder, const std::vector<int>& frames);

/// Frames whose pictures are there, from 1 up to the first gap.
int count_pictures(const std::filesystem::path& run_folder);

/// Where the motion of all states is kept.
std::filesystem::path motion_path(const std::filesystem::path& run_folder);

/// The path of a frame's state, or picture, in a run's folder, whoever holds it.
std::filesystem::path state_path(const std::filesystem::path& run_folder, int frame);
std::filesystem::path picture_path(const std::filesystem::path& run_folder, int frame);

}  // namespace umax
