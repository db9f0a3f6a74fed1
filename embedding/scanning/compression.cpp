#include "embedding/scanning/compression.h"

#include <zlib.h>

namespace umax {
namespace {

const Bytef* as_bytes(std::string_view text) {
  return reinterpret_cast<const Bytef*>(text.data());
}

}  // namespace

std::optional<std::string> decompress(std::string_view compressed, std::size_t size) {
  std::string block(size, '\0');
  uLongf length = size;
  const int result =
      uncompress(reinterpret_cast<Bytef*>(block.data()), &length, as_bytes(compressed), uLong(compressed.size()));
  if (result != Z_OK || length != size) return std::nullopt;
  return block;
}

std::uint32_t crc32_of(std::string_view bytes) {
  return std::uint32_t(crc32(0, as_bytes(bytes), uInt(bytes.size())));
}

}  // namespace umax
