// 8-bit sRGB codes of linear values by a table, for whole pictures.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace umax {

/// What byte_from_unit(srgb_from_linear(value)) gives, for every value.
class SrgbCodes {
 public:
  SrgbCodes();

  std::uint8_t operator()(float linear) const {
    if (!(linear > 0)) return 0;
    const float value = std::min(linear, 1.0f);
    const Cell& cell = cells_[std::size_t(value * float(num_cells))];
    return std::uint8_t(cell.code + (value >= cell.next ? 1 : 0));
  }

 private:
  // so many that none holds the beginnings of two codes, at the steepest end of the curve either
  static constexpr int num_cells = 4096;
  struct Cell {
    float next;          // where the next code begins, or infinite
    std::uint32_t code;  // of the cell's lower end
  };
  std::array<Cell, num_cells + 1> cells_;
};

}  // namespace umax
