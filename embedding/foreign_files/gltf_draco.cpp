#include "embedding/foreign_files/gltf_draco.h"

#include <draco/compression/decode.h>

#include <algorithm>

#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "embedding/foreign_files/gltf_json.h"

namespace umax {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* extension = "KHR_draco_mesh_compression";
constexpr int kind_uint32 = 5125, kind_float = 5126;  // glTF's numbers for the types of components

std::string decode_base64(std::string_view text) {
  std::string bytes;
  unsigned group = 0;
  int bits = 0;
  for (const char c : text) {
    const int digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (digit < 0) break;
    group = group << 6 | unsigned(digit);
    if ((bits += 6) < 8) continue;
    bits -= 8;
    bytes += char(group >> bits & 255);
  }
  return bytes;
}

/// Rewrites one document; what is not as it should be throws Json::exception or Error.
class DracoDecoder {
 public:
  DracoDecoder(const std::filesystem::path& path, const GltfParts& parts, Json& document)
      : folder_(path.parent_path()), parts_(parts), document_(document) {}

  /// False where there is nothing to decode, or something cannot be.
  bool run() {
    bool found = false;
    for (Json& mesh : document_.at("meshes"))
      for (Json& primitive : mesh.at("primitives")) {
        if (!primitive.contains("extensions") || !primitive["extensions"].contains(extension)) continue;
        if (!decode(primitive)) return false;
        primitive["extensions"].erase(extension);
        found = true;
      }
    if (!found) return false;
    for (const char* list : {"extensionsUsed", "extensionsRequired"})
      if (document_.contains(list))
        document_[list].erase(std::remove(document_[list].begin(), document_[list].end(), extension),
                              document_[list].end());
    document_["buffers"].push_back({{"byteLength", decoded_.size()}, {"uri", draco_buffer_name}});
    return true;
  }
  std::string take_decoded() { return std::move(decoded_); }

 private:
  std::string buffer(const Json& description) const {
    if (!description.contains("uri")) return std::string(parts_.binary);
    const std::string uri = description["uri"];
    const std::size_t comma = uri.find(',');
    if (uri.starts_with("data:") && comma != uri.npos) return decode_base64(std::string_view(uri).substr(comma + 1));
    return read_file(folder_ / uri);
  }

  /// Adds numbers to the decoded ones and lets the accessor name them.
  void put(Json& accessor, const void* numbers, std::size_t size, int kind, std::size_t count) {
    accessor["bufferView"] = document_["bufferViews"].size();
    accessor["componentType"] = kind;
    accessor["count"] = count;
    for (const char* key : {"byteOffset", "normalized"}) accessor.erase(key);
    document_["bufferViews"].push_back(
        {{"buffer", document_.at("buffers").size()}, {"byteOffset", decoded_.size()}, {"byteLength", size}});
    decoded_.append(static_cast<const char*>(numbers), size);
  }

  bool decode(Json& primitive) {
    const Json compressed = primitive["extensions"][extension];
    const Json& view = document_.at("bufferViews").at(compressed.at("bufferView").get<std::size_t>());
    const std::string bytes = buffer(document_.at("buffers").at(view.at("buffer").get<std::size_t>()));
    const std::size_t offset = view.value("byteOffset", std::size_t(0)), size = view.at("byteLength");
    if (offset > bytes.size() || size > bytes.size() - offset) return false;
    draco::DecoderBuffer input;
    input.Init(bytes.data() + offset, size);
    auto mesh = draco::Decoder().DecodeMeshFromBuffer(&input);
    if (!mesh.ok()) return false;
    put_indices(primitive, *mesh.value());
    return put_attributes(primitive, compressed.at("attributes"), *mesh.value());
  }

  void put_indices(Json& primitive, const draco::Mesh& mesh) {
    std::vector<std::uint32_t> indices;
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
      for (const draco::PointIndex& point : mesh.face(f)) indices.push_back(point.value());
    put(document_.at("accessors").at(primitive.at("indices").get<std::size_t>()), indices.data(),
        indices.size() * sizeof(std::uint32_t), kind_uint32, indices.size());
  }

  /// Of those that pictures and shapes need; accessors without data would be errors.
  bool put_attributes(Json& primitive, const Json& ids, const draco::Mesh& mesh) {
    Json kept = Json::object();
    for (const char* name : {"POSITION", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"}) {
      if (!primitive.at("attributes").contains(name) || !ids.contains(name)) continue;
      const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(ids[name].get<std::uint32_t>());
      if (!attribute) return false;
      const auto width = std::size_t(attribute->num_components());
      std::vector<float> values(width * mesh.num_points());
      for (draco::PointIndex point(0); point < mesh.num_points(); ++point)
        if (!attribute->ConvertValue<float>(attribute->mapped_index(point), std::int8_t(width),
                                            &values[width * point.value()]))
          return false;
      kept[name] = primitive["attributes"][name];
      put(document_.at("accessors").at(kept[name].get<std::size_t>()), values.data(), values.size() * sizeof(float),
          kind_float, mesh.num_points());
    }
    primitive["attributes"] = kept;
    return true;
  }

  std::filesystem::path folder_;
  const GltfParts& parts_;
  Json& document_;
  std::string decoded_;
};

}  // namespace

std::optional<DecodedGltf> without_draco(const std::filesystem::path& path, const std::string& bytes) {
  try {
    const auto parts = gltf_parts(bytes);
    if (!parts || parts->json.find(extension) == parts->json.npos) return std::nullopt;
    Json document = Json::parse(parts->json);
    DracoDecoder decoder(path, *parts, document);
    if (!decoder.run()) return std::nullopt;
    return DecodedGltf{with_json(*parts, document.dump()), decoder.take_decoded()};
  } catch (const Json::exception&) {
    return std::nullopt;  // the library that reads the file says better what is wrong
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace umax
