// A folder for files that nobody wants to keep.
#pragma once

#include <filesystem>

namespace umax {

/// A new folder that goes, with all that is in it, when this goes.
class ScratchFolder {
 public:
  /// In `place`. Throws Error (cannot_create) where that takes no folder.
  explicit ScratchFolder(const std::filesystem::path& place = std::filesystem::temp_directory_path());
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace umax
