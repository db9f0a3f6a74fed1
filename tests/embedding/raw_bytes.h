// The bytes of a number, as binary files have them.
#pragma once

#include <algorithm>
#include <cstring>
#include <string>

namespace umax::testing {

template <class T>
std::string raw(T value, bool big_endian = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

}  // namespace umax::testing
