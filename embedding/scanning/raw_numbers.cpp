#include "embedding/scanning/raw_numbers.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace umax {
namespace {

template <class T>
std::vector<double> decode(std::string_view bytes, bool big_endian) {
  std::vector<double> numbers(bytes.size() / sizeof(T));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    char raw[sizeof(T)];
    std::memcpy(raw, bytes.data() + i * sizeof(T), sizeof(T));
    if (big_endian) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof value);
    numbers[i] = double(value);
  }
  return numbers;
}

}  // namespace

int size_of(NumberType type) {
  constexpr int sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[int(type)];
}

std::vector<double> decode_numbers(std::string_view bytes, NumberType type, bool big_endian) {
  switch (type) {
    case NumberType::int8:
      return decode<std::int8_t>(bytes, big_endian);
    case NumberType::uint8:
      return decode<std::uint8_t>(bytes, big_endian);
    case NumberType::int16:
      return decode<std::int16_t>(bytes, big_endian);
    case NumberType::uint16:
      return decode<std::uint16_t>(bytes, big_endian);
    case NumberType::int32:
      return decode<std::int32_t>(bytes, big_endian);
    case NumberType::uint32:
      return decode<std::uint32_t>(bytes, big_endian);
    case NumberType::int64:
      return decode<std::int64_t>(bytes, big_endian);
    case NumberType::uint64:
      return decode<std::uint64_t>(bytes, big_endian);
    case NumberType::float32:
      return decode<float>(bytes, big_endian);
    case NumberType::float64:
      break;
  }
  return decode<double>(bytes, big_endian);
}

}  // namespace umax
