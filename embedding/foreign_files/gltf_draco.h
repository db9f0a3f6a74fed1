// glTF files whose meshes are compressed by Draco: the same meshes as plain numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace umax {

/// What is decoded lies in a buffer of its own, which the JSON names draco_buffer_name.
struct DecodedGltf {
  std::string bytes;   // of the .gltf or .glb file
  std::string buffer;  // what is to be found under the name
};
constexpr const char* draco_buffer_name = "umax-decoded-draco.bin";

/// Positions, texture coordinates, colours and indices decoded, other attributes of such parts left out. Nothing where
/// the file has no such part, or one that cannot be decoded.
std::optional<DecodedGltf> without_draco(const std::filesystem::path& path, const std::string& bytes);

}  // namespace umax
