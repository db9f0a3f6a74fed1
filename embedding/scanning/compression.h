// Inflates the compressed blocks of mesh files and computes the checksums of PNG chunks: all that needs zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace umax {

/// The block decompressed, or nothing unless it is sound and has exactly `size` bytes.
std::optional<std::string> decompress(std::string_view compressed, std::size_t size);

/// CRC-32 as PNG and zip have it.
std::uint32_t crc32_of(std::string_view bytes);

}  // namespace umax
