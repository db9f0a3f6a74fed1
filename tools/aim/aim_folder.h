// The folder of an aiming: the runs, and what shows them.
#pragma once

#include <filesystem>
#include <string>

#include "tools/system/locked_folder.h"

namespace umax {

/// Owns the lock on an aiming's folder while it lives.
class AimFolder {
 public:
  /// Throws what LockedFolder throws. overwrite: removes the old runs and what was made of them.
  AimFolder(const std::filesystem::path& path, ExistingFolder existing);

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path record() const;  // aim.json: what the page shows, as numbers
  std::filesystem::path page() const { return path() / "aim.html"; }
  std::filesystem::path strip() const { return path() / "before-after.png"; }
  std::filesystem::path lines() const { return path() / "lines.toml"; }
  std::filesystem::path plot(const std::string& key) const { return path() / ("plot-" + key + ".svg"); }
  std::filesystem::path scene(const std::string& run) const { return path() / "scenes" / (run + ".toml"); }
  std::filesystem::path run(const std::string& run) const { return path() / "runs" / run; }

  /// Removes page, strip, lines and plots: they show another search.
  void remove_pages() const;

 private:
  LockedFolder folder_;
};

}  // namespace umax
