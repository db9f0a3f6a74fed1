#include "render/image/cryptomatte.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <set>

namespace umax {
namespace {

std::uint32_t scrambled(std::uint32_t block) {
  return std::rotl(block * 0xcc9e2d51u, 15) * 0x1b873593u;
}

std::uint32_t byte_at(std::string_view bytes, std::size_t i) {
  return static_cast<unsigned char>(bytes[i]);
}

/// A text in the quotes of JSON.
std::string json_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      quoted += fmt::format("\\u{:04x}", int(c));
    else
      quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

std::uint32_t murmur_hash_32(std::string_view bytes) {
  std::uint32_t hash = 0;
  const std::size_t whole = bytes.size() / 4 * 4;
  for (std::size_t i = 0; i < whole; i += 4) {
    const std::uint32_t block =
        byte_at(bytes, i) | byte_at(bytes, i + 1) << 8 | byte_at(bytes, i + 2) << 16 | byte_at(bytes, i + 3) << 24;
    hash = std::rotl(hash ^ scrambled(block), 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t rest = 0;
  for (std::size_t i = bytes.size(); i > whole; --i) rest = rest << 8 | byte_at(bytes, i - 1);
  hash ^= scrambled(rest);
  hash ^= std::uint32_t(bytes.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return hash ^ hash >> 16;
}

std::uint32_t cryptomatte_bits(std::string_view name) {
  const std::uint32_t hash = murmur_hash_32(name), exponent = hash >> 23 & 255;
  return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

float cryptomatte_number(std::string_view name) {
  return std::bit_cast<float>(cryptomatte_bits(name));
}

ExrTexts cryptomatte_texts(const std::string& name, const std::vector<std::string>& names) {
  const std::string prefix = "cryptomatte/" + fmt::format("{:08x}", murmur_hash_32(name)).substr(0, 7) + "/";
  std::string manifest;
  for (const std::string& one : std::set<std::string>(names.begin(), names.end()))
    manifest += fmt::format("{}{}:\"{:08x}\"", manifest.empty() ? "" : ",", json_text(one), cryptomatte_bits(one));
  return {{prefix + "conversion", "uint32_to_float32"},
          {prefix + "hash", "MurmurHash3_32"},
          {prefix + "manifest", "{" + manifest + "}"},
          {prefix + "name", name}};
}

std::vector<Layer> cryptomatte_layers(const std::string& name, const Image& pairs) {
  assert(pairs.channels % 4 == 0);
  std::vector<Layer> layers;
  for (int first = 0; first < pairs.channels; first += 4) {
    Image two(pairs.width, pairs.height, 4);
    for (int y = 0; y < pairs.height; ++y)
      for (int x = 0; x < pairs.width; ++x) std::copy_n(pairs.pixel(x, y) + first, 4, two.pixel(x, y));
    layers.push_back({fmt::format("{}{:02}", name, first / 4), std::move(two)});
  }
  return layers;
}

}  // namespace umax
