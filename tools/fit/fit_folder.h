// The folder of a fit: a scene snippet and a plot.
#pragma once

#include <filesystem>

#include "tools/system/locked_folder.h"

namespace umax {

/// Throws what LockedFolder throws for a folder that is there already.
void check_fit_folder(const std::filesystem::path& path, ExistingFolder existing);

/// Owns the lock on a fit's folder while it lives.
class FitFolder {
 public:
  /// Throws what LockedFolder throws. What an older fit left is replaced file by file.
  FitFolder(const std::filesystem::path& path, ExistingFolder existing);

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path snippet() const;
  std::filesystem::path plot() const { return path() / "fit.svg"; }

 private:
  LockedFolder folder_;
};

}  // namespace umax
