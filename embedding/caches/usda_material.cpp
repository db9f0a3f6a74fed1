#include "embedding/caches/usda_material.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "embedding/caches/number_text.h"
#include "embedding/caches/usda_file.h"

namespace umax {
namespace {

/// Names of the materials' prims.
std::vector<std::string> prims_of(const MovingSurface& surface) {
  if (surface.materials.size() == 1) return {"material"};
  std::vector<std::string> names{"surface"};  // the mesh is called that
  for (const SurfaceMaterial& material : surface.materials) names.push_back(usd_name(material.name));
  names = material_names(names);
  names.erase(names.begin());
  return names;
}

std::string color_input(const SurfaceMaterial& material, const std::string& path) {
  if (!material.texture.empty())
    return fmt::format("color3f inputs:diffuseColor.connect = <{}/texture.outputs:rgb>", path);
  if (material.vertex_colors)
    return fmt::format("color3f inputs:diffuseColor.connect = <{}/paint.outputs:result>", path);
  std::string out = "color3f inputs:diffuseColor = (";
  append_row(out, material.base_color, ", ");
  return out + ")";
}

/// A shader that reads a primvar of the mesh.
std::string reader_text(const char* name, const char* id, const char* primvar, const char* type) {
  return fmt::format(
      "\n        def Shader \"{}\"\n        {{\n            uniform token info:id = \"{}\"\n"
      "            string inputs:varname = \"{}\"\n            {} outputs:result\n        }}\n",
      name, id, primvar, type);
}

std::string texture_text(const SurfaceMaterial& material, const std::string& path) {
  const Vector3f& color = material.base_color;
  std::string out = fmt::format(
      "\n        def Shader \"texture\"\n        {{\n            uniform token info:id = \"UsdUVTexture\"\n"
      "            asset inputs:file = @./{}@\n            float4 inputs:scale = ({}, {}, {}, 1)\n"
      "            token inputs:sourceColorSpace = \"sRGB\"\n"
      "            float2 inputs:st.connect = <{}/st.outputs:result>\n"
      "            token inputs:wrapS = \"repeat\"\n            token inputs:wrapT = \"repeat\"\n"
      "            float3 outputs:rgb\n        }}\n",
      material.texture, color.x(), color.y(), color.z(), path);
  return out + reader_text("st", "UsdPrimvarReader_float2", "st", "float2");
}

/// path: of the prim, which is called `prim`.
std::string material_text(const SurfaceMaterial& material, const std::string& prim, const std::string& path) {
  std::string out = fmt::format(
      "    def Material \"{}\"\n    {{\n        token outputs:surface.connect = "
      "<{}/surface.outputs:surface>\n\n        def Shader \"surface\"\n        {{\n"
      "            uniform token info:id = \"UsdPreviewSurface\"\n            {}\n"
      "            float inputs:roughness = {}\n            float inputs:metallic = {}\n"
      "            float inputs:clearcoat = {}\n            float inputs:clearcoatRoughness = {}\n"
      "            float inputs:ior = {}\n            token outputs:surface\n        }}\n",
      prim, path, color_input(material, path), material.roughness, material.metallic, material.clearcoat,
      material.clearcoat_roughness, material.ior);
  if (!material.texture.empty())
    out += texture_text(material, path);
  else if (material.vertex_colors)
    out += reader_text("paint", "UsdPrimvarReader_float3", "displayColor", "float3");
  return out + "    }\n";
}

std::string subset_text(const std::string& prim, const std::string& path, const std::vector<int>& faces) {
  return fmt::format(
      "\n        def GeomSubset \"{}\" (\n            prepend apiSchemas = [\"MaterialBindingAPI\"]\n        )\n"
      "        {{\n            uniform token elementType = \"face\"\n"
      "            uniform token familyName = \"materialBind\"\n            int[] indices = [{}]\n"
      "            rel material:binding = <{}>\n        }}\n",
      prim, fmt::join(faces, ", "), path);
}

}  // namespace

std::string usda_binding(const MovingSurface& surface, const std::string& root) {
  const std::vector<std::string> prims = prims_of(surface);
  if (prims.size() == 1) return fmt::format("        rel material:binding = </{}/{}>\n", root, prims[0]);
  std::string out = "        uniform token subsetFamily:materialBind:familyType = \"partition\"\n";
  for (std::size_t i = 0; i < prims.size(); ++i)
    out += subset_text(prims[i], fmt::format("/{}/{}", root, prims[i]), surface.triangles_of(i));
  return out;
}

std::string usda_materials(const MovingSurface& surface, const std::string& root) {
  const std::vector<std::string> prims = prims_of(surface);
  std::string out;
  for (std::size_t i = 0; i < prims.size(); ++i)
    out += material_text(surface.materials[i], prims[i], fmt::format("/{}/{}", root, prims[i]));
  return out;
}

}  // namespace umax
