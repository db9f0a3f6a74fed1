// The folder of a tuning: the variants' scenes and runs, and what shows them side by side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/system/locked_folder.h"

namespace umax {

/// Owns the lock on a tuning's folder while it lives.
class TuneFolder {
 public:
  /// Throws what LockedFolder throws. overwrite: removes the old runs and what was made of them.
  TuneFolder(const std::filesystem::path& path, ExistingFolder existing);

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path record() const;  // tune.json: what the page shows, as numbers
  std::filesystem::path page() const { return path() / "tune.html"; }
  std::filesystem::path sheet() const { return path() / "sheet.png"; }
  std::filesystem::path clip() const { return path() / "variants.mp4"; }
  std::filesystem::path scene(const std::string& variant) const { return path() / "scenes" / (variant + ".toml"); }
  std::filesystem::path run(const std::string& variant) const { return path() / "runs" / variant; }

  /// Removes page, sheet and clip: they show other variants.
  void remove_pages() const;

 private:
  LockedFolder folder_;
};

}  // namespace umax
