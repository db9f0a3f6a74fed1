// The folder of many runs of a scene: their scenes, the runs, and a record of what was found.
#pragma once

#include <filesystem>
#include <string>

#include "tools/system/locked_folder.h"

namespace umax {

/// What one verb leaves in such a folder, by which it is known again.
struct TrialFolderKind {
  FolderKind folder;
  const char* record;   // "tune.json": what the page shows, as numbers
  const char* program;  // "umax tune": what the record begins with
};

/// Holds the folder while it lives.
class TrialFolder {
 public:
  /// Makes the folders of scenes and runs, and a record without findings where there is none. Throws what LockedFolder
  /// throws. overwrite: removes the old scenes and runs; is_replaced() tells it, so that what was made of them can follow.
  TrialFolder(const std::filesystem::path& path, ExistingFolder existing, const TrialFolderKind& kind);

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path record() const { return path() / record_; }
  std::filesystem::path scene(const std::string& run) const { return path() / "scenes" / (run + ".toml"); }
  std::filesystem::path run(const std::string& run) const { return path() / "runs" / run; }

 protected:
  bool is_replaced() const { return is_replaced_; }

 private:
  LockedFolder folder_;
  const char* record_;
  bool is_replaced_;
};

}  // namespace umax
