#include "embedding/foreign_files/foreign_material.h"

#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>

#include "embedding/mesh_record/mesh_materials.h"

namespace umax {
namespace {

constexpr std::array color_types{aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE};

bool is_gltf(const std::string& ending) {
  return ending == "gltf" || ending == "glb";
}

/// Nothing for what the library makes up where a file says nothing.
std::optional<Vector3d> color_of(const aiMaterial& material, const std::string& name, bool gltf) {
  aiColor4D color;
  const bool found = (gltf && material.Get(AI_MATKEY_BASE_COLOR, color) == AI_SUCCESS) ||
                     material.Get(AI_MATKEY_COLOR_DIFFUSE, color) == AI_SUCCESS;
  const bool made_up = name == AI_DEFAULT_MATERIAL_NAME || (gltf && name.empty() && color == aiColor4D(1, 1, 1, 1));
  if (!found || made_up) return std::nullopt;
  const Vector3d linear(color.r, color.g, color.b);
  if (!linear.allFinite()) return std::nullopt;
  return linear.cwiseMax(0.0).cwiseMin(1.0).eval();
}

/// Its place among the file's pictures, where it is now.
int embed(const aiTexture& texture, MeshFile& file) {
  if (texture.mHeight > 0) return -1;  // single texels, in none of the formats of pictures
  std::string bytes(reinterpret_cast<const char*>(texture.pcData), texture.mWidth);
  const auto found = std::find(file.embedded_textures.begin(), file.embedded_textures.end(), bytes);
  if (found == file.embedded_textures.end()) {
    file.embedded_textures.push_back(std::move(bytes));
    return int(file.embedded_textures.size()) - 1;
  }
  return int(found - file.embedded_textures.begin());
}

}  // namespace

MeshMaterial read_material(const std::filesystem::path& path, const std::string& ending, const aiScene& scene,
                           unsigned index, MeshFile& file) {
  MeshMaterial result;
  if (index >= scene.mNumMaterials) return result;
  const aiMaterial& material = *scene.mMaterials[index];
  result.name = material.GetName().C_Str();
  result.color = color_of(material, result.name, is_gltf(ending));
  if (is_gltf(ending) && result.color) result.texture_tint = *result.color;
  for (const aiTextureType type : color_types) {
    aiString name;
    if (result.has_texture() || material.GetTexture(type, 0, &name) != AI_SUCCESS || name.length == 0) continue;
    if (const aiTexture* inside = scene.GetEmbeddedTexture(name.C_Str()))
      result.embedded_texture = embed(*inside, file);
    else
      result.texture = find_texture(path, name.C_Str(), file.notes);
  }
  return result;
}

unsigned texture_channel(const aiScene& scene, unsigned material) {
  int channel = 0;
  if (material < scene.mNumMaterials)
    for (const aiTextureType type : color_types) {
      if (scene.mMaterials[material]->GetTextureCount(type) == 0) continue;
      if (scene.mMaterials[material]->Get(AI_MATKEY_UVWSRC(type, 0), channel) == AI_SUCCESS) break;
    }
  return channel > 0 && channel < AI_MAX_NUMBER_OF_TEXTURECOORDS ? unsigned(channel) : 0u;
}

}  // namespace umax
