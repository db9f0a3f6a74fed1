// Mesh files that a large library of others reads, which may fail in any way at all: not for the program itself, but
// for a helper program of its own (tools/import).
#pragma once

#include <functional>

#include "embedding/mesh_record/mesh_file.h"

namespace umax {

/// Reads glTF, FBX, COLLADA by the given lower-case ending. Calls take(mesh) before the library gives its memory
/// back: who ends then need not wait for that. Throws Error (bad_data) where the file is not sound.
void read_with_assimp(const std::filesystem::path& path, const std::string& ending,
                      const std::function<void(MeshFile&&)>& take);

/// The same as a value.
MeshFile read_with_assimp(const std::filesystem::path& path, const std::string& ending);

}  // namespace umax
