// The readers behind load_mesh(): each fills what the file holds; load_mesh() does the checks that all formats share.
#pragma once

#include <string>

#include "embedding/mesh_files/mesh_io.h"

namespace umax {

/// Wavefront OBJ. Throws Error (bad_data) for malformed lines and indices out of range.
MeshFile read_obj(const std::filesystem::path& path);

/// PLY, text or binary. Throws Error (bad_data) that names the place in the file.
MeshFile read_ply(const std::filesystem::path& path);

/// OFF, text or binary. Throws Error (bad_data) that names the place in the file.
MeshFile read_off(const std::filesystem::path& path);

/// STL, text or binary. Throws Error (bad_data): truncated, or the place in the file.
MeshFile read_stl(const std::filesystem::path& path);

}  // namespace umax
