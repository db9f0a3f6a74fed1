#include "embedding/scanning/raw_numbers.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace umax {
namespace {

template <class T>
double decode_one(const char* bytes, bool big_endian) {
  char raw[sizeof(T)];
  std::memcpy(raw, bytes, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof value);
  return double(value);
}

/// Calls visit(a number of the type).
template <class Visit>
auto with_type(NumberType type, const Visit& visit) {
  switch (type) {
    case NumberType::int8:
      return visit(std::int8_t());
    case NumberType::uint8:
      return visit(std::uint8_t());
    case NumberType::int16:
      return visit(std::int16_t());
    case NumberType::uint16:
      return visit(std::uint16_t());
    case NumberType::int32:
      return visit(std::int32_t());
    case NumberType::uint32:
      return visit(std::uint32_t());
    case NumberType::int64:
      return visit(std::int64_t());
    case NumberType::uint64:
      return visit(std::uint64_t());
    case NumberType::float32:
      return visit(float());
    case NumberType::float64:
      break;
  }
  return visit(double());
}

}  // namespace

int size_of(NumberType type) {
  constexpr int sizes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[int(type)];
}

std::vector<double> decode_numbers(std::string_view bytes, NumberType type, bool big_endian) {
  return with_type(type, [&](auto kind) {
    using T = decltype(kind);
    std::vector<double> numbers(bytes.size() / sizeof(T));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] = decode_one<T>(bytes.data() + i * sizeof(T), big_endian);
    return numbers;
  });
}

double decode_number(const char* bytes, NumberType type, bool big_endian) {
  return with_type(type, [&](auto kind) { return decode_one<decltype(kind)>(bytes, big_endian); });
}

}  // namespace umax
