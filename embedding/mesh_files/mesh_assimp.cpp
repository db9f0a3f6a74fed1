#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <fstream>
#include <functional>
#include <limits>

#include "core/base/srgb.h"
#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/surface/topology.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

// one mesh of the file where a node puts it
struct Instance {
  const aiMesh* mesh = nullptr;
  aiMatrix4x4 file_from_mesh;
};

void collect(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent, std::vector<Instance>& instances) {
  const aiMatrix4x4 here = parent * node.mTransformation;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) instances.push_back({scene.mMeshes[node.mMeshes[m]], here});
  for (unsigned c = 0; c < node.mNumChildren; ++c) collect(scene, *node.mChildren[c], here, instances);
}

bool is_triangle(const aiFace& face) {
  return face.mNumIndices == 3;
}

struct Totals {
  long long vertices = 0, triangles = 0;
  bool texture = true, colors = true;  // every instance has them
};

Totals count(const std::vector<Instance>& instances) {
  Totals totals;
  for (const Instance& instance : instances) {
    const aiMesh& mesh = *instance.mesh;
    const auto triangles = std::count_if(mesh.mFaces, mesh.mFaces + mesh.mNumFaces, is_triangle);
    totals.vertices += mesh.mNumVertices;
    totals.triangles += triangles;
    if (triangles == 0) continue;
    totals.texture &= mesh.HasTextureCoords(0);
    totals.colors &= mesh.HasVertexColors(0);
  }
  return totals;
}

void append(const Path& path, const Instance& instance, bool linear_colors, Eigen::Index first_vertex,
            Eigen::Index& next_triangle, TriangleMesh& mesh) {
  const aiMesh& part = *instance.mesh;
  const bool mirrored = instance.file_from_mesh.Determinant() < 0;
  for (unsigned v = 0; v < part.mNumVertices; ++v) {
    const aiVector3D p = instance.file_from_mesh * part.mVertices[v];
    mesh.positions.row(first_vertex + v) << p.x, p.y, p.z;
    if (mesh.colors.rows() == 0) continue;
    const aiColor4D& c = part.mColors[0] ? part.mColors[0][v] : aiColor4D(1, 1, 1, 1);
    const Eigen::RowVector3d color(c.r, c.g, c.b);
    mesh.colors.row(first_vertex + v) =
        linear_colors ? color : Eigen::RowVector3d(color.unaryExpr(&linear_from_srgb<double>));
  }
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (!is_triangle(face)) continue;
    for (int k = 0; k < 3; ++k) {
      const unsigned corner = face.mIndices[mirrored && k > 0 ? 3 - k : k];
      if (corner >= part.mNumVertices)
        refuse_mesh(path, "a face names a vertex that does not exist",
                    fmt::format("{} of {} vertices", corner, part.mNumVertices),
                    "the file is damaged: export it again");
      mesh.triangles(next_triangle, k) = int(first_vertex) + int(corner);
      if (mesh.texture_coordinates.rows() > 0)
        mesh.texture_coordinates.row(3 * next_triangle + k) << part.mTextureCoords[0][corner].x,
            part.mTextureCoords[0][corner].y;
    }
    ++next_triangle;
  }
}

// The reader of these formats gives every corner its own vertex: those at one position become one again, per part.
void join_corners(const std::vector<Eigen::Index>& part_sizes, MeshFile& file) {
  TriangleMesh& mesh = file.mesh;
  const Eigen::Index before = mesh.num_vertices();
  std::vector<int> new_index(std::size_t(before), -1);
  Eigen::Index first = 0, kept = 0;
  for (Eigen::Index size : part_sizes) {
    const std::vector<int> welded = weld(mesh.positions.middleRows(first, size));
    for (Eigen::Index v = 0; v < size; ++v) {
      const bool is_first = welded[std::size_t(v)] == v;
      new_index[std::size_t(first + v)] = is_first ? int(kept) : new_index[std::size_t(first + welded[std::size_t(v)])];
      if (!is_first) continue;
      mesh.positions.row(kept) = mesh.positions.row(first + v).eval();
      if (mesh.colors.rows() > 0) mesh.colors.row(kept) = mesh.colors.row(first + v).eval();
      ++kept;
    }
    first += size;
  }
  mesh.positions.conservativeResize(kept, 3);
  if (mesh.colors.rows() > 0) mesh.colors.conservativeResize(kept, 3);
  for (int& corner : mesh.triangles.reshaped()) corner = new_index[std::size_t(corner)];
  if (kept < before)
    file.notes.push_back(fmt::format("{} corners of faces were joined into {} vertices", before, kept));
}

template <class T>
std::optional<T> metadata(const aiScene& scene, const char* key) {
  T value{};
  if (scene.mMetaData && scene.mMetaData->Get(key, value)) return value;
  return std::nullopt;
}

std::string attribute_after(const std::string& text, const std::string& tag, const std::string& attribute) {
  const std::size_t start = text.find("<" + tag);
  if (start == text.npos) return "";
  const std::size_t end = std::min(text.find('>', start), text.size());
  const std::size_t name = text.find(attribute + "=", start);
  if (name >= end) return "";
  const char quote = text[name + attribute.size() + 1];
  const std::size_t value = name + attribute.size() + 2;
  return text.substr(value, text.find(quote, value) - value);
}

void read_collada_asset(const Path& path, MeshFile& file) {
  std::ifstream in(path, std::ios::binary);
  std::string text(1 << 16, '\0');
  in.read(text.data(), std::streamsize(text.size()));
  text.resize(std::size_t(in.gcount()));
  const double unit = std::atof(attribute_after(text, "unit", "meter").c_str());
  file.unit = unit > 0 ? unit : 1.0;
  file.up = "y";
  if (text.find("<up_axis>Z_UP") != text.npos) file.up = "z";
  if (text.find("<up_axis>X_UP") != text.npos) file.up = "x";
}

void read_fbx_settings(const aiScene& scene, MeshFile& file) {
  double centimetres = 1;
  if (const auto factor = metadata<double>(scene, "UnitScaleFactor")) centimetres = *factor;
  if (const auto factor = metadata<float>(scene, "UnitScaleFactor")) centimetres = double(*factor);
  file.unit = centimetres > 0 ? 0.01 * centimetres : 0.01;
  const int axis = metadata<int>(scene, "UpAxis").value_or(1), sign = metadata<int>(scene, "UpAxisSign").value_or(1);
  if (axis >= 0 && axis <= 2) file.up = fmt::format("{}{}", sign < 0 ? "-" : "", "xyz"[axis]);
}

// first colour texture that exists beside the file
Path find_texture(const Path& path, const aiScene& scene, std::vector<std::string>& notes) {
  for (unsigned m = 0; m < scene.mNumMaterials; ++m)
    for (aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
      aiString name;
      if (scene.mMaterials[m]->GetTexture(type, 0, &name) != AI_SUCCESS || name.length == 0) continue;
      if (name.data[0] == '*' || scene.GetEmbeddedTexture(name.C_Str())) {
        notes.push_back("a texture inside the mesh file is left out: save it as a file of its own");
        continue;
      }
      std::string text = name.C_Str();
      std::replace(text.begin(), text.end(), '\\', '/');
      const Path folder = path.parent_path();
      for (const Path& candidate : {folder / text, folder / Path(text).filename()})
        if (std::filesystem::is_regular_file(candidate)) return std::filesystem::absolute(candidate).lexically_normal();
      notes.push_back("the texture " + text + " that the mesh names does not exist");
    }
  return {};
}

// sets node transforms aside that the reader adds on its own to turn and scale the scene: unit and up tell the same
void take_file_axes(const Path& path, const std::string& ending, aiScene& scene, MeshFile& file) {
  if (ending == "gltf" || ending == "glb") {
    file.unit = 1.0;
    file.up = "y";
  }
  if (ending == "dae") read_collada_asset(path, file);
  if (ending == "fbx") read_fbx_settings(scene, file);
  if (ending == "dae" || ending == "fbx") scene.mRootNode->mTransformation = aiMatrix4x4();
}

}  // namespace

MeshFile read_with_assimp(const Path& path, const std::string& ending) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  const aiScene* imported = importer.ReadFile(path.string(), aiProcess_Triangulate);
  if (!imported || !imported->mRootNode) {
    const std::string reason = importer.GetErrorString();
    refuse_mesh(path, fmt::format("not a sound {} file: {}", ending, reason.substr(0, reason.find('\n'))), "",
                "the file is truncated or damaged: export it again");
  }
  aiScene& scene = *const_cast<aiScene*>(imported);  // the importer owns it; only the root's transform is changed
  MeshFile file;
  take_file_axes(path, ending, scene, file);

  std::vector<Instance> instances;
  collect(scene, *scene.mRootNode, aiMatrix4x4(), instances);
  const Totals totals = count(instances);
  if (totals.vertices > std::numeric_limits<int>::max() || 3 * totals.triangles > std::numeric_limits<int>::max())
    refuse_mesh(path, "the mesh has more vertices or triangles than can be counted", std::to_string(totals.vertices),
                "reduce it");
  file.mesh.positions.resize(totals.vertices, 3);
  file.mesh.triangles.resize(totals.triangles, 3);
  if (totals.texture && totals.triangles > 0) file.mesh.texture_coordinates.resize(3 * totals.triangles, 2);
  if (totals.colors && totals.triangles > 0) file.mesh.colors.resize(totals.vertices, 3);

  Eigen::Index next_vertex = 0, next_triangle = 0;
  std::vector<Eigen::Index> part_sizes;
  for (const Instance& instance : instances) {
    append(path, instance, ending == "gltf" || ending == "glb", next_vertex, next_triangle, file.mesh);
    part_sizes.push_back(instance.mesh->mNumVertices);
    next_vertex += part_sizes.back();
  }
  if (ending == "fbx" || ending == "dae") join_corners(part_sizes, file);
  file.num_parts = int(instances.size());
  file.texture = find_texture(path, scene, file.notes);
  return file;
}

}  // namespace umax
