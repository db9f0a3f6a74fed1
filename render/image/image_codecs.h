// The decoders behind image_io.h, one per file format. `name` is what error messages call the file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "render/image/image_io.h"

namespace umax::codec {

constexpr int max_extent = 65536;             // [px] per side
constexpr std::size_t max_pixels = 1u << 28;  // 268 megapixels: beyond is taken for a damaged header

struct Codes {  // a PNG's or JPEG's own numbers
  int width = 0, height = 0, channels = 3, bits = 8;
  std::vector<std::uint16_t> values;
};

bool is_png(std::string_view bytes);
bool is_jpeg(std::string_view bytes);
bool is_exr(std::string_view bytes);
bool is_hdr(std::string_view bytes);

Codes decode_png(std::string_view bytes, const std::string& name);
Codes decode_jpeg(std::string_view bytes, const std::string& name);
std::vector<Layer> decode_exr(std::string_view bytes, const std::string& name);
Image decode_hdr(std::string_view bytes, const std::string& name);
std::string encode_exr(const std::vector<Layer>& layers, const ExrHeader& header, const std::string& name);

/// Whether so many bytes of a file can hold what comes to `count` bytes when they are unpacked, for which memory is to be
/// taken: no format makes more than that of a byte, but in pictures so small that it does not matter.
constexpr bool can_hold(std::size_t file_bytes, std::size_t count, std::size_t most_per_byte) {
  constexpr std::size_t small = 1u << 22;
  return count <= small + most_per_byte * file_bytes;
}

/// Throws Error 65 "is not a whole picture".
[[noreturn]] inline void fail_data(const std::string& name, const std::string& what) {
  throw Error(Fault::bad_data, {name, what, "", "give a whole PNG, JPEG, EXR or HDR file"});
}

}  // namespace umax::codec
