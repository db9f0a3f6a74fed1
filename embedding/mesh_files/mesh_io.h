// Meshes from files: OBJ, PLY, STL, OFF, glTF, FBX and COLLADA; and the surface of meshes of hexes (hex_mesh_io.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

struct MeshFile {
  TriangleMesh mesh;  // in file units and axes; all parts in one mesh, quads and polygons cut into triangles
  std::optional<double> unit =
      std::nullopt;  // [m] length of one file unit, where the format says (FBX, COLLADA; glTF: 1)
  std::optional<std::string> up =
      std::nullopt;                // "x", "y", "z" or "-x" …, where the format says (FBX, COLLADA; glTF: "y")
  std::filesystem::path texture;   // colour texture that the file names, absolute; may be empty
  std::vector<std::string> notes;  // what a user may want to know; empty when all is plain
  int num_parts = 0;               // objects or mesh instances in the file
};

/// Reads a mesh. Vertex order and number are the file's own for OBJ, PLY and OFF (and glTF but for unused ones); STL
/// has three vertices a facet; FBX and COLLADA have one vertex per distinct position of a part. No normals. A triangle
/// that names a vertex twice is left out, with a note. Throws Error: not_found (missing, a folder, not readable),
/// bad_data (empty, truncated, without triangles or area, coordinates that are not finite or beyond 1e9, no extent,
/// unknown format, indices out of range).
MeshFile load_mesh(const std::filesystem::path& path);

/// The file endings that load_mesh() knows, as a list for messages: "obj, ply, …".
std::string known_mesh_formats();

}  // namespace umax
