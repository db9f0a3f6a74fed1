// What a mesh file holds, whatever its format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// What a file says of the colour of some of its triangles.
struct MeshMaterial {
  std::string name;
  std::optional<Vector3d> color = std::nullopt;  // linear Rec. 709, where there is no texture; none: the file says none
  Vector3d texture_tint{1, 1, 1};                // multiplies the texture
  std::filesystem::path texture = {};            // picture beside the file, absolute; empty: none
  int embedded_texture = -1;                     // of MeshFile::embedded_textures; -1: none

  bool has_texture() const { return !texture.empty() || embedded_texture >= 0; }
  bool has_color() const { return color || has_texture(); }
};

struct MeshFile {
  TriangleMesh mesh;  // in file units and axes; all parts in one mesh, quads and polygons cut into triangles
  std::optional<double> unit =
      std::nullopt;  // [m] length of one file unit, where the format says (FBX, COLLADA; glTF: 1)
  std::optional<std::string> up =
      std::nullopt;                          // "x", "y", "z" or "-x" …, where the format says (FBX, COLLADA; glTF: "y")
  std::vector<MeshMaterial> materials = {};  // those that triangles have, as mesh.materials counts them; empty: none
  std::vector<std::string> embedded_textures = {};  // bytes of pictures inside the file
  std::vector<int> vertex_in_file = {};  // #V place of each vertex in the file's own order; empty: all are as there
  Points loose_vertices = {};            // #L x 3 those of no triangle, which the mesh lacks; in the file's order
  Points loose_colors = {};              // #L x 3, or empty: theirs, as mesh.colors
  std::vector<std::string> notes = {};   // what a user may want to know; empty when all is plain
  int num_parts = 0;                     // objects or mesh instances in the file
};

}  // namespace umax
