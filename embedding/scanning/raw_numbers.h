// Numbers as mesh files store them in binary.
#pragma once

#include <string_view>
#include <vector>

namespace umax {

enum class NumberType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

/// [bytes]
int size_of(NumberType type);

/// As many numbers as there are; the bytes must be a multiple of the type's size.
std::vector<double> decode_numbers(std::string_view bytes, NumberType type, bool big_endian);

/// The number that these bytes, as many as the type has, are.
double decode_number(const char* bytes, NumberType type, bool big_endian);

}  // namespace umax
