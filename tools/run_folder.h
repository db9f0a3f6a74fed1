// The folder of a run: where its files are, who may write to it, what may be replaced.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace umax {

/// What to do when the folder exists already.
enum class ExistingFolder {
  refuse,     // Error 73
  keep,       // --resume: go on with what is there
  overwrite,  // --overwrite: remove what a run made, and nothing else
};

/// Throws what RunFolder would throw for a folder that is there already. Changes nothing: for a look before long work.
void check_run_folder(const std::filesystem::path& path, ExistingFolder existing);

/// Owns the lock on a run's folder while it lives.
class RunFolder {
 public:
  /// Makes the folder (and its parents) and locks it. Throws Error: cannot_create (73) when it cannot be made, is no
  /// folder, exists and may not be replaced, or holds files that no run made; try_again (75) when a living run has it.
  RunFolder(const std::filesystem::path& path, ExistingFolder existing);
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path scene() const { return path_ / "scene.toml"; }
  std::filesystem::path steps() const { return path_ / "steps.csv"; }
  std::filesystem::path record() const { return path_ / "run.json"; }
  std::filesystem::path clip() const { return path_ / "clip.mp4"; }
  std::filesystem::path states() const { return path_ / "states"; }
  std::filesystem::path frames() const { return path_ / "frames"; }
  std::filesystem::path plots() const { return path_ / "plots"; }
  std::filesystem::path state(int frame) const;
  std::filesystem::path picture(int frame, const std::string& extension = ".png") const;

  /// Removes all pictures and the clip: they were made with other settings.
  void remove_pictures() const;

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

/// Makes a folder inside a run's, if it is not there. Throws Error (cannot_create).
void create_folder(const std::filesystem::path& path);

/// Whether a run of this program made the folder.
bool is_run_folder(const std::filesystem::path& path);

/// Frames whose state files are there, from 1 up to the first gap.
int count_states(const std::filesystem::path& run_folder);

/// The path of a frame's state in a run's folder, whoever holds it.
std::filesystem::path state_path(const std::filesystem::path& run_folder, int frame);

}  // namespace umax
