// The folder of an aiming: the runs, and what shows them.
#pragma once

#include <filesystem>
#include <string>

#include "tools/trials/trial_folder.h"

namespace umax {

/// Owns the lock on an aiming's folder while it lives.
class AimFolder : public TrialFolder {
 public:
  /// Throws what TrialFolder throws. overwrite: removes the old runs and what was made of them.
  AimFolder(const std::filesystem::path& path, ExistingFolder existing);

  std::filesystem::path page() const { return path() / "aim.html"; }
  std::filesystem::path strip() const { return path() / "before-after.png"; }
  std::filesystem::path lines() const { return path() / "lines.toml"; }
  std::filesystem::path plot(const std::string& key) const { return path() / ("plot-" + key + ".svg"); }

  /// Removes page, strip, lines and plots: they show another search.
  void remove_pages() const;
};

}  // namespace umax
