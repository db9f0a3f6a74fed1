// What readers of mesh files share about materials: which triangles have which, and where their textures are.
#pragma once

#include "embedding/mesh_record/mesh_file.h"

namespace umax {

/// Keeps the materials that triangles have, in the order of their first use; without a texture where triangles have no
/// texture coordinates (has_coordinates: #T, or empty: all have them). One for all needs no indices; none that says
/// anything: none are kept. Call with mesh.materials filled (-1: the file says none) or empty (all have the first).
void settle_materials(MeshFile& file, const std::vector<char>& has_coordinates = {});

/// The picture that a mesh file names: at that path from the file's folder, or by its name in it. Empty, with a note,
/// where there is none.
std::filesystem::path find_texture(const std::filesystem::path& mesh_file, std::string name,
                                   std::vector<std::string>& notes);

}  // namespace umax
