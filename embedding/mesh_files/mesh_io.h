// Meshes from files: OBJ, PLY, STL, OFF, glTF, FBX and COLLADA; and the surface of meshes of hexes (hex_mesh_io.h).
#pragma once

#include <filesystem>
#include <string>

#include "embedding/mesh_record/mesh_file.h"

namespace umax {

/// Reads a mesh. Vertex order is the file's own for OBJ, PLY and OFF (and glTF); STL has three vertices a facet; FBX and
/// COLLADA have one vertex per distinct position of a part. No normals. Vertices of no triangle (kept apart) and triangles
/// that name a vertex twice are left out, with a note; a texture that is not there is a note, too. glTF, FBX and COLLADA are read
/// by a helper program (foreign_mesh.h). Throws Error: not_found (missing, a folder, not readable), bad_data
/// (empty, truncated, without triangles or area, coordinates that are not finite or beyond 1e9, no extent, unknown
/// format, indices out of range, a reader that fails or takes too much), unavailable (no helper program).
MeshFile load_mesh(const std::filesystem::path& path);

/// The file endings that load_mesh() knows, as a list for messages: "obj, ply, …".
std::string known_mesh_formats();

}  // namespace umax
