#include "render/image/srgb_code.h"

#include <bit>
#include <limits>

#include "core/base/srgb.h"

namespace umax {
namespace {

int code_of(float linear) {
  return byte_from_unit(srgb_from_linear(linear));
}

/// The smallest value above 0 of at least this code: positive numbers are ordered as their bits are.
float begin_of(int code) {
  auto below = std::bit_cast<std::uint32_t>(0.0f), above = std::bit_cast<std::uint32_t>(1.0f);
  while (above - below > 1) {
    const std::uint32_t middle = below + (above - below) / 2;
    (code_of(std::bit_cast<float>(middle)) >= code ? above : below) = middle;
  }
  return std::bit_cast<float>(above);
}

}  // namespace

SrgbCodes::SrgbCodes() {
  int code = 0;
  float next = begin_of(1);
  for (int i = 0; i <= num_cells; ++i) {
    const float lower = float(i) / float(num_cells);
    if (lower >= next) next = ++code < 255 ? begin_of(code + 1) : std::numeric_limits<float>::infinity();
    cells_[std::size_t(i)] = {.next = next, .code = std::uint32_t(code)};
  }
}

}  // namespace umax
