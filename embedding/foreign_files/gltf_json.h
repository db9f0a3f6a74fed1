// The JSON of a glTF file, taken out of it and put back.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace umax {

/// Where the parts of a .gltf or .glb file are.
struct GltfParts {
  std::string_view json, binary;  // binary: of a .glb, its buffer; may be empty
  bool is_binary = false;
};

/// Nothing where a .glb file is shorter than it says.
std::optional<GltfParts> gltf_parts(std::string_view bytes);

/// The file with another JSON.
std::string with_json(const GltfParts& parts, std::string json);

}  // namespace umax
