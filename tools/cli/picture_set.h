// The pictures of a folder, of a run, or of a clip, to be compared one by one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/system/scratch_folder.h"

namespace umax {

/// Pictures in a folder, by name. Those of a clip are in a folder that goes with this.
class PictureSet {
 public:
  /// source: a folder with pictures, a run's folder, or a clip. Throws Error: not_found without pictures, bad_data for what
  /// is no clip, unavailable where a clip needs ffmpeg.
  explicit PictureSet(const std::filesystem::path& source);

  /// As the user named it.
  const std::filesystem::path& source() const { return source_; }
  bool is_clip() const { return decoded_.has_value(); }

  const std::vector<std::string>& names() const { return names_; }  // ascending
  std::filesystem::path path_of(const std::string& name) const { return folder_ / name; }

 private:
  std::filesystem::path source_, folder_;
  std::optional<ScratchFolder> decoded_;
  std::vector<std::string> names_;
};

/// Whether the file is a clip by its name.
bool is_clip_file(const std::filesystem::path& path);

/// Names of the pictures that both have. Throws Error (not_found, bad_data) where one has others.
std::vector<std::string> names_of_both(const PictureSet& a, const PictureSet& b);

}  // namespace umax
