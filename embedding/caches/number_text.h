// Numbers as text, in the fewest digits that are read back as the same number, whatever the locale.
#pragma once

#include <Eigen/Core>
#include <charconv>
#include <string>

namespace umax {

/// Appends a float, double or whole number.
template <class Number>
void append_number(std::string& out, Number value) {
  char digits[40];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  out.append(digits, end);
}

/// Appends the parts of a row, `between` them.
template <class Row>
void append_row(std::string& out, const Row& row, const char* between) {
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    if (i > 0) out += between;
    append_number(out, row[i]);
  }
}

}  // namespace umax
