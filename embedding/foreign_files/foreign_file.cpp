#include "embedding/foreign_files/foreign_file.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <map>

#include "core/base/srgb.h"
#include "core/files/read_file.h"
#include "embedding/foreign_files/foreign_material.h"
#include "embedding/foreign_files/gltf_draco.h"
#include "embedding/foreign_files/gltf_scene.h"
#include "embedding/mesh_record/mesh_materials.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/surface/topology.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

// one mesh of the file where a node puts it
struct Instance {
  const aiMesh* mesh = nullptr;
  aiMatrix4x4 file_from_mesh;
  const aiVector3D* texture_coordinates = nullptr;  // those that its material's texture takes
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
  bool texture = false, colors = true;  // some instance has them, every instance has them
};

Totals count(const std::vector<Instance>& instances) {
  Totals totals;
  for (const Instance& instance : instances) {
    const aiMesh& mesh = *instance.mesh;
    const auto triangles = std::count_if(mesh.mFaces, mesh.mFaces + mesh.mNumFaces, is_triangle);
    totals.vertices += mesh.mNumVertices;
    totals.triangles += triangles;
    if (triangles == 0) continue;
    totals.texture |= instance.texture_coordinates != nullptr;
    totals.colors &= mesh.HasVertexColors(0);
  }
  return totals;
}

// what append() adds to
struct Assembly {
  MeshFile file;
  std::map<unsigned, int> material_place;  // of the scene's materials among the file's
  std::vector<char> has_coordinates;       // #T
  Eigen::Index next_vertex = 0;
};

void append_vertices(const Instance& instance, bool gltf, Assembly& assembly) {
  const aiMesh& part = *instance.mesh;
  TriangleMesh& mesh = assembly.file.mesh;
  const int place = assembly.material_place[part.mMaterialIndex];
  const Eigen::RowVector3d tint = assembly.file.materials[std::size_t(place)].texture_tint.transpose();
  for (unsigned v = 0; v < part.mNumVertices; ++v) {
    const aiVector3D p = instance.file_from_mesh * part.mVertices[v];
    mesh.positions.row(assembly.next_vertex + v) << p.x, p.y, p.z;
    if (mesh.colors.rows() == 0) continue;
    const aiColor4D& c = part.mColors[0] ? part.mColors[0][v] : aiColor4D(1, 1, 1, 1);
    const Eigen::RowVector3d color(c.r, c.g, c.b);
    // in glTF the material's colour multiplies the vertices'
    mesh.colors.row(assembly.next_vertex + v) = gltf ? Eigen::RowVector3d(color.cwiseProduct(tint))
                                                     : Eigen::RowVector3d(color.unaryExpr(&linear_from_srgb<double>));
  }
}

void append(const Path& path, const Instance& instance, bool gltf, Assembly& assembly) {
  const aiMesh& part = *instance.mesh;
  TriangleMesh& mesh = assembly.file.mesh;
  append_vertices(instance, gltf, assembly);
  const bool mirrored = instance.file_from_mesh.Determinant() < 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (!is_triangle(face)) continue;
    const auto triangle = Eigen::Index(mesh.materials.size());
    for (int k = 0; k < 3; ++k) {
      const unsigned corner = face.mIndices[mirrored && k > 0 ? 3 - k : k];
      if (corner >= part.mNumVertices)
        refuse_mesh(path, "a face names a vertex that does not exist",
                    fmt::format("{} of {} vertices", corner, part.mNumVertices),
                    "the file is damaged: export it again");
      mesh.triangles(triangle, k) = int(assembly.next_vertex) + int(corner);
      if (mesh.texture_coordinates.rows() == 0) continue;
      const aiVector3D* coordinates = instance.texture_coordinates;
      mesh.texture_coordinates.row(3 * triangle + k) << (coordinates ? coordinates[corner].x : 0),
          (coordinates ? coordinates[corner].y : 0);
    }
    mesh.materials.push_back(assembly.material_place[part.mMaterialIndex]);
    assembly.has_coordinates.push_back(instance.texture_coordinates != nullptr);
  }
  assembly.next_vertex += part.mNumVertices;
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

[[noreturn]] void refuse_file(const Path& path, const std::string& ending, const std::string& reason) {
  refuse_mesh(path, fmt::format("not a sound {} file: {}", ending, reason.substr(0, reason.find('\n'))), "",
              "the file is truncated or damaged: export it again");
}

/// The version that an FBX file says it has; 7300 for 7.3; 0 where it says none.
int fbx_version(const Path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string start(4096, '\0');
  in.read(start.data(), std::streamsize(start.size()));
  start.resize(std::size_t(in.gcount()));
  constexpr std::size_t binary_place = 23;
  std::uint32_t version = 0;
  if (start.starts_with("Kaydara FBX Binary") && start.size() >= binary_place + sizeof version) {
    std::memcpy(&version, start.data() + binary_place, sizeof version);
    return int(std::min(version, 1000000u));
  }
  const std::size_t key = start.find("FBXVersion:");
  return key == start.npos ? 0 : std::atoi(start.c_str() + key + std::strlen("FBXVersion:"));
}

void require_new_fbx(const Path& path) {
  constexpr int oldest = 7100;
  const int version = fbx_version(path);
  if (version > 0 && version < oldest)
    refuse_mesh(
        path, "is of an old version of FBX that is not read",
        fmt::format("FBX {}.{}", version / 1000, version % 1000 / 100),
        "open it in a program that reads it (Autodesk's FBX Converter, Maya, 3ds Max) and save it as FBX 2011 or "
        "later, or as OBJ or glTF");
}

/// Hands out other bytes than the file holds, and a buffer that is nowhere else.
class PatchedFile : public Assimp::DefaultIOSystem {
 public:
  PatchedFile(const Path& path, const std::string& bytes, const std::string& buffer)
      : path_(path.string()), bytes_(bytes), buffer_(buffer) {}
  bool Exists(const char* file) const override { return is_buffer(file) || DefaultIOSystem::Exists(file); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (file != path_ && !is_buffer(file)) return DefaultIOSystem::Open(file, mode);
    const std::string& bytes = is_buffer(file) ? buffer_ : bytes_;
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }

 private:
  bool is_buffer(const std::string& file) const { return !buffer_.empty() && file.ends_with(draco_buffer_name); }
  std::string path_;
  const std::string &bytes_, &buffer_;
};

/// Null, and why, where it is not sound.
aiScene* import(const Path& path, Assimp::Importer& importer) {
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_Triangulate);
  // the importer owns the scene; only the root's transform is changed
  return scene && scene->mRootNode ? const_cast<aiScene*>(scene) : nullptr;
}

std::vector<Instance> instances_of(const aiScene& scene) {
  std::vector<Instance> instances;
  collect(scene, *scene.mRootNode, aiMatrix4x4(), instances);
  for (Instance& instance : instances)
    instance.texture_coordinates = instance.mesh->mTextureCoords[texture_channel(scene, instance.mesh->mMaterialIndex)];
  return instances;
}

void make_room(const Path& path, const Totals& totals, Assembly& assembly) {
  if (totals.vertices > std::numeric_limits<int>::max() || 3 * totals.triangles > std::numeric_limits<int>::max())
    refuse_mesh(path, "the mesh has more vertices or triangles than can be counted", std::to_string(totals.vertices),
                "reduce it");
  TriangleMesh& mesh = assembly.file.mesh;
  mesh.positions.resize(totals.vertices, 3);
  mesh.triangles.resize(totals.triangles, 3);
  if (totals.texture && totals.triangles > 0) mesh.texture_coordinates.resize(3 * totals.triangles, 2);
  if (totals.colors && totals.triangles > 0) mesh.colors.resize(totals.vertices, 3);
  mesh.materials.reserve(std::size_t(totals.triangles));
}

MeshFile assemble(const Path& path, const std::string& ending, aiScene& scene) {
  const bool gltf = ending == "gltf" || ending == "glb";
  Assembly assembly;
  take_file_axes(path, ending, scene, assembly.file);
  const std::vector<Instance> instances = instances_of(scene);
  make_room(path, count(instances), assembly);
  for (const Instance& instance : instances) {
    const unsigned material = instance.mesh->mMaterialIndex;
    if (!assembly.material_place.try_emplace(material, int(assembly.file.materials.size())).second) continue;
    assembly.file.materials.push_back(read_material(path, ending, scene, material, assembly.file));
  }
  std::vector<Eigen::Index> part_sizes;
  for (const Instance& instance : instances) {
    append(path, instance, gltf, assembly);
    part_sizes.push_back(instance.mesh->mNumVertices);
  }
  if (ending == "fbx" || ending == "dae") join_corners(part_sizes, assembly.file);
  settle_materials(assembly.file, assembly.has_coordinates);
  assembly.file.num_parts = int(instances.size());
  return std::move(assembly.file);
}

/// The file as it would be if it named a scene to show and was not compressed; nothing where that does not help.
std::optional<MeshFile> read_patched(const Path& path, const std::string& ending) {
  if (ending != "gltf" && ending != "glb") return std::nullopt;
  DecodedGltf patched{read_file(path), {}};
  const auto decoded = without_draco(path, patched.bytes);
  if (decoded) patched = *decoded;
  const auto with_scene = with_default_scene(patched.bytes);
  if (with_scene) patched.bytes = *with_scene;
  if (!decoded && !with_scene) return std::nullopt;
  Assimp::Importer importer;
  importer.SetIOHandler(new PatchedFile(path, patched.bytes, patched.buffer));  // the importer deletes it
  aiScene* scene = import(path, importer);
  if (!scene) return std::nullopt;
  MeshFile file = assemble(path, ending, *scene);
  if (with_scene)
    file.notes.insert(file.notes.begin(),
                      "the file names no scene to show: its first is taken, or else all its meshes");
  return file;
}

}  // namespace

void read_with_assimp(const Path& path, const std::string& ending, const std::function<void(MeshFile&&)>& take) {
  if (ending == "fbx") require_new_fbx(path);
  Assimp::Importer importer;
  aiScene* scene = import(path, importer);
  std::optional<MeshFile> file;
  if (scene) file = assemble(path, ending, *scene);
  if (!file || file->mesh.num_triangles() == 0)
    if (auto patched = read_patched(path, ending)) file = std::move(patched);
  if (!file) refuse_file(path, ending, importer.GetErrorString());
  take(std::move(*file));
}

MeshFile read_with_assimp(const Path& path, const std::string& ending) {
  MeshFile result;
  read_with_assimp(path, ending, [&](MeshFile&& file) { result = std::move(file); });
  return result;
}

}  // namespace umax
