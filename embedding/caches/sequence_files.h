// A folder of meshes, one a frame, as an animation: which files, in which order.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace umax {

struct SequenceFile {
  int frame = 0;  // the number that its name ends with
  std::filesystem::path path;
};

/// The folder's OBJ or PLY files by their numbers (walk_0001.obj, walk_0002.obj …), which are equally far apart. Throws
/// Error: not_found (no folder); bad_data where there are none, or both kinds, names that differ in more than their
/// number, a number twice, or one that is missing.
std::vector<SequenceFile> find_sequence(const std::filesystem::path& folder);

/// Of the bytes of a point cache, or of all files of a folder's sequence with their names. Throws as find_sequence().
std::string sha256_of_cache(const std::filesystem::path& path);

}  // namespace umax
