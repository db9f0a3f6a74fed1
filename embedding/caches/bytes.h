// Numbers as bytes of a file, in the order that its format has.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace umax {

static_assert(std::endian::native == std::endian::little, "files are written as the memory has them");

/// The bytes of a value, or of an array's values, as a little-endian file has them.
template <class T>
void append_bytes(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class Array>
std::string_view bytes_of(const Array& array) {
  return {reinterpret_cast<const char*>(array.data()), std::size_t(array.size()) * sizeof(*array.data())};
}

/// Four bytes turned round.
inline std::uint32_t swapped(std::uint32_t value) {
  return __builtin_bswap32(value);
}

inline void append_big_endian(std::string& out, std::uint32_t value) {
  append_bytes(out, swapped(value));
}
inline void append_big_endian(std::string& out, float value) {
  append_big_endian(out, std::bit_cast<std::uint32_t>(value));
}

}  // namespace umax
