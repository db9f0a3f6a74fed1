// The counts and sizes that an OpenVDB file promises, against the bytes that are there.
#pragma once

#include <filesystem>

namespace umax {

/// Walks through the file as OpenVDB would and stops at the first count, length or position that the file cannot hold:
/// OpenVDB believes them all, and a flipped bit would make it wait for hours, take all memory or write beyond its own.
/// Trees of float and vec3s grids are walked to their last leaf; of grids of other types the metadata. Throws
/// std::runtime_error with what is wrong. Of old files it takes those of format 222 (OpenVDB 2, 2013) and later.
void check_vdb_promises(const std::filesystem::path& path);

}  // namespace umax
