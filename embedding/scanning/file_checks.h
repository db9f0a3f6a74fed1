// Checks that every reader of a mesh or grid file makes, and the error that names the file, the fault and the remedy.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/types.h"

namespace umax {

[[noreturn]] void refuse_mesh(const std::filesystem::path& path, const std::string& what, const std::string& value,
                              const std::string& remedy);

/// Throws Error: not_found (missing, a folder, not readable), bad_data (empty). thing: what the file should be.
void require_readable_file(const std::filesystem::path& path, const std::string& thing = "mesh file");

/// "obj" of "a/b.OBJ".
std::string lower_ending(const std::filesystem::path& path);

/// Throw Error (bad_data) for coordinates that are not finite, beyond 1e9, or all in one point.
void require_finite(const std::filesystem::path& path, const Points& positions);
void require_sensible_box(const std::filesystem::path& path, const Points& positions);

}  // namespace umax
