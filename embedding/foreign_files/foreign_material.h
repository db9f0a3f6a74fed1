// Materials of assimp's scenes: colours and textures, beside the file or inside it.
#pragma once

#include "embedding/mesh_record/mesh_file.h"

struct aiMaterial;
struct aiScene;

namespace umax {

/// What the scene's material says. Embedded pictures join the file's once; what is missing is noted.
MeshMaterial read_material(const std::filesystem::path& path, const std::string& ending, const aiScene& scene,
                           unsigned index, MeshFile& file);

/// Which of a part's sets of texture coordinates its material's texture takes.
unsigned texture_channel(const aiScene& scene, unsigned material);

}  // namespace umax
