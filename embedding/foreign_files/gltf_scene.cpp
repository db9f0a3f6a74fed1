#include "embedding/foreign_files/gltf_scene.h"

#include <nlohmann/json.hpp>
#include <set>

#include "embedding/foreign_files/gltf_json.h"

namespace umax {
namespace {

using Json = nlohmann::ordered_json;

std::size_t size_of(const Json& document, const char* list) {
  return document.contains(list) && document[list].is_array() ? document[list].size() : 0;
}

/// Nodes that are nobody's child.
Json root_nodes(const Json& document) {
  std::set<std::size_t> children;
  for (const Json& node : document["nodes"])
    if (node.contains("children"))
      for (const Json& child : node["children"])
        if (child.is_number_unsigned()) children.insert(child.get<std::size_t>());
  Json roots = Json::array();
  for (std::size_t node = 0; node < document["nodes"].size(); ++node)
    if (children.count(node) == 0) roots.push_back(node);
  return roots;
}

/// False where there is nothing to add.
bool add_default_scene(Json& document) {
  if (!document.is_object() || document.contains("scene")) return false;
  document["scene"] = 0;
  if (size_of(document, "scenes") > 0) return true;
  if (size_of(document, "nodes") == 0)
    for (std::size_t mesh = 0; mesh < size_of(document, "meshes"); ++mesh)
      document["nodes"].push_back({{"mesh", mesh}});
  if (size_of(document, "nodes") == 0) return false;
  document["scenes"] = Json::array({{{"nodes", root_nodes(document)}}});
  return true;
}

std::optional<std::string> rewritten(const std::string& bytes) {
  const auto parts = gltf_parts(bytes);
  if (!parts) return std::nullopt;
  Json document = Json::parse(parts->json);
  if (!add_default_scene(document)) return std::nullopt;
  return with_json(*parts, document.dump());
}

}  // namespace

std::optional<std::string> with_default_scene(const std::string& bytes) {
  try {
    return rewritten(bytes);
  } catch (const Json::exception&) {
    return std::nullopt;  // the library that reads the file says better what is wrong
  }
}

}  // namespace umax
