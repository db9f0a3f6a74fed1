#include "embedding/foreign_files/gltf_json.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace umax {
namespace {

constexpr std::size_t header_size = 12, chunk_header_size = 8;  // of .glb: magic, version, size; size, kind

std::size_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}
std::string bytes_of(std::size_t number) {
  const auto small = std::uint32_t(number);
  return {reinterpret_cast<const char*>(&small), sizeof small};
}

std::string chunk(const char* kind, std::string bytes, char filler) {
  bytes.resize((bytes.size() + 3) / 4 * 4, filler);
  return bytes_of(bytes.size()) + std::string(kind, 4) + bytes;
}

}  // namespace

std::optional<GltfParts> gltf_parts(std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return GltfParts{.json = bytes, .binary = {}, .is_binary = false};
  GltfParts parts{.json = {}, .binary = {}, .is_binary = true};
  constexpr std::size_t begin = header_size + chunk_header_size;
  if (bytes.size() < begin || number_at(bytes, header_size) > bytes.size() - begin) return std::nullopt;
  parts.json = bytes.substr(begin, number_at(bytes, header_size));
  const std::string_view rest = bytes.substr(begin + parts.json.size());
  if (rest.size() >= chunk_header_size)
    parts.binary = rest.substr(chunk_header_size, std::min(number_at(rest, 0), rest.size() - chunk_header_size));
  return parts;
}

std::string with_json(const GltfParts& parts, std::string json) {
  if (!parts.is_binary) return json;
  std::string chunks = chunk("JSON", std::move(json), ' ');
  if (!parts.binary.empty()) chunks += chunk("BIN\0", std::string(parts.binary), '\0');
  return "glTF" + bytes_of(2) + bytes_of(header_size + chunks.size()) + chunks;
}

}  // namespace umax
