// The readers behind load_mesh(): each fills what the file holds; load_mesh() does the checks that all formats share.
#pragma once

#include <string>

#include "embedding/mesh_files/mesh_io.h"

namespace umax {

/// Wavefront OBJ. Throws Error (bad_data) for malformed lines and indices out of range.
MeshFile read_obj(const std::filesystem::path& path);

/// PLY, STL, OFF, glTF, FBX, COLLADA by the given lower-case ending. Throws Error (bad_data) where the file is not
/// sound.
MeshFile read_with_assimp(const std::filesystem::path& path, const std::string& ending);

/// Checks what a header promises against the file's size or the lines that follow. Throws Error (bad_data): truncated.
/// Returns the number of vertices that the file says it has, or -1 where the format does not say.
long long check_promised_size(const std::filesystem::path& path, const std::string& ending);

}  // namespace umax
