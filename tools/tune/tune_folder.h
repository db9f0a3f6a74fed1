// The folder of a tuning: the variants' scenes and runs, and what shows them side by side.
#pragma once

#include <filesystem>
#include <string>

#include "tools/trials/trial_folder.h"

namespace umax {

/// Owns the lock on a tuning's folder while it lives.
class TuneFolder : public TrialFolder {
 public:
  /// Throws what TrialFolder throws. overwrite: removes the old runs and what was made of them.
  TuneFolder(const std::filesystem::path& path, ExistingFolder existing);

  std::filesystem::path page() const { return path() / "tune.html"; }
  std::filesystem::path sheet() const { return path() / "sheet.png"; }
  std::filesystem::path clip() const { return path() / "variants.mp4"; }

  /// Removes page, sheet and clip: they show other variants.
  void remove_pages() const;
};

}  // namespace umax
