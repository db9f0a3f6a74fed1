#include "scenes/quantity.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/base/trimmed.h"

namespace umax {
namespace {

// A factor is numerator / denominator, both exact in binary, so that "7 cm" is the same double as 0.07.
struct NamedUnit {
  std::string_view symbol;
  double numerator, denominator;
  Dimension dimension;
};

constexpr Dimension ratio_dimension{};
constexpr double degrees_per_radian_pi = 180.0;

constexpr std::array named_units{
    NamedUnit{"m", 1, 1, units::length.dimension},
    NamedUnit{"um", 1, 1e6, units::length.dimension},
    NamedUnit{"µm", 1, 1e6, units::length.dimension},
    NamedUnit{"mm", 1, 1e3, units::length.dimension},
    NamedUnit{"cm", 1, 1e2, units::length.dimension},
    NamedUnit{"dm", 1, 1e1, units::length.dimension},
    NamedUnit{"km", 1e3, 1, units::length.dimension},
    NamedUnit{"in", 254, 1e4, units::length.dimension},
    NamedUnit{"inch", 254, 1e4, units::length.dimension},
    NamedUnit{"ft", 3048, 1e4, units::length.dimension},
    NamedUnit{"yd", 9144, 1e4, units::length.dimension},
    NamedUnit{"s", 1, 1, units::time.dimension},
    NamedUnit{"ms", 1, 1e3, units::time.dimension},
    NamedUnit{"us", 1, 1e6, units::time.dimension},
    NamedUnit{"min", 60, 1, units::time.dimension},
    NamedUnit{"h", 3600, 1, units::time.dimension},
    NamedUnit{"Hz", 1, 1, units::rate.dimension},
    NamedUnit{"kg", 1, 1, {.mass = 1}},
    NamedUnit{"g", 1, 1e3, {.mass = 1}},
    NamedUnit{"t", 1e3, 1, {.mass = 1}},
    NamedUnit{"N", 1, 1, {.length = 1, .mass = 1, .time = -2}},
    NamedUnit{"mN", 1, 1e3, {.length = 1, .mass = 1, .time = -2}},
    NamedUnit{"kN", 1e3, 1, {.length = 1, .mass = 1, .time = -2}},
    NamedUnit{"Pa", 1, 1, units::pressure.dimension},
    NamedUnit{"hPa", 1e2, 1, units::pressure.dimension},
    NamedUnit{"kPa", 1e3, 1, units::pressure.dimension},
    NamedUnit{"MPa", 1e6, 1, units::pressure.dimension},
    NamedUnit{"GPa", 1e9, 1, units::pressure.dimension},
    NamedUnit{"bar", 1e5, 1, units::pressure.dimension},
    NamedUnit{"J", 1, 1, units::energy.dimension},
    NamedUnit{"uJ", 1, 1e6, units::energy.dimension},
    NamedUnit{"mJ", 1, 1e3, units::energy.dimension},
    NamedUnit{"kJ", 1e3, 1, units::energy.dimension},
    NamedUnit{"MJ", 1e6, 1, units::energy.dimension},
    NamedUnit{"W", 1, 1, units::power.dimension},
    NamedUnit{"mW", 1, 1e3, units::power.dimension},
    NamedUnit{"kW", 1e3, 1, units::power.dimension},
    NamedUnit{"deg", 1, 1, units::angle.dimension},
    NamedUnit{"°", 1, 1, units::angle.dimension},
    NamedUnit{"rad", degrees_per_radian_pi, std::numbers::pi, units::angle.dimension},
    NamedUnit{"turn", 360, 1, units::angle.dimension},
    NamedUnit{"rev", 360, 1, units::angle.dimension},
    NamedUnit{"%", 1, 1e2, ratio_dimension},
    NamedUnit{"percent", 1, 1e2, ratio_dimension},
};

const NamedUnit* find_unit(std::string_view symbol) {
  for (const NamedUnit& unit : named_units)
    if (unit.symbol == symbol) return &unit;
  return nullptr;
}

bool starts_with(std::string_view text, std::string_view prefix) {
  return text.substr(0, prefix.size()) == prefix;
}

void skip_spaces(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
}

// Takes "^3", "^-1", "3", "²" or "³" off the front; 1 if there is none, 0 if it makes no sense.
int take_exponent(std::string_view& text) {
  if (starts_with(text, "²") || starts_with(text, "³")) {
    const int exponent = starts_with(text, "²") ? 2 : 3;
    text.remove_prefix(std::string_view("²").size());
    return exponent;
  }
  const bool caret = starts_with(text, "^");
  if (caret) text.remove_prefix(1);
  int exponent = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), exponent);
  if (error != std::errc()) return caret ? 0 : 1;
  text.remove_prefix(std::size_t(end - text.data()));
  return std::abs(exponent) <= 9 ? exponent : 0;
}

// A product of powers of named units: "kg/m^3", "N m", "J/(…)" is not understood.
struct UnitProduct {
  double numerator = 1, denominator = 1;
  Dimension dimension;

  void multiply(const NamedUnit& unit, int exponent) {
    for (int i = 0; i < std::abs(exponent); ++i) {
      numerator *= exponent > 0 ? unit.numerator : unit.denominator;
      denominator *= exponent > 0 ? unit.denominator : unit.numerator;
    }
    dimension.length += exponent * unit.dimension.length;
    dimension.mass += exponent * unit.dimension.mass;
    dimension.time += exponent * unit.dimension.time;
    dimension.angle += exponent * unit.dimension.angle;
  }
};

// Takes letters and signs off the front up to an exponent or an operator.
std::string_view take_symbol(std::string_view& text) {
  std::size_t end = text.find_first_of(" \t*/^+-.,()0123456789");
  for (const std::string_view stop : {"²", "³", "·"}) end = std::min(end, text.find(stop));
  const std::string_view symbol = text.substr(0, end);
  text.remove_prefix(symbol.size());
  return symbol;
}

std::optional<UnitProduct> parse_unit(std::string_view text, std::string& problem) {
  UnitProduct product;
  int sign = 1;
  if (starts_with(text, "1/")) {
    text.remove_prefix(2);
    sign = -1;
  }
  while (true) {
    skip_spaces(text);
    const std::string_view symbol = take_symbol(text);
    const NamedUnit* unit = find_unit(symbol);
    if (!unit) {
      problem = symbol.empty() ? "has a unit that cannot be read" : "has the unknown unit " + std::string(symbol);
      return std::nullopt;
    }
    const int exponent = take_exponent(text);
    if (exponent == 0) {
      problem = "has an exponent that cannot be read";
      return std::nullopt;
    }
    product.multiply(*unit, sign * exponent);
    skip_spaces(text);
    if (text.empty()) return product;
    sign = 1;
    if (text.front() == '/') sign = -1;
    if (text.front() == '/' || text.front() == '*') text.remove_prefix(1);
    if (starts_with(text, "·")) text.remove_prefix(std::string_view("·").size());
  }
}

constexpr std::string_view blanks = " \t\r\n";

template <class T>
std::string shortest(T value) {
  std::array<char, 64> buffer;
  if (value == 0) value = 0;  // not "-0", which reads back as the integer 0
  char* const first = buffer.data();
  char* const last = first + buffer.size();
  const bool plain = value == 0 || (std::abs(value) >= T(1e-6) && std::abs(value) < T(1e15));
  const auto format = plain ? std::chars_format::fixed : std::chars_format::scientific;
  return std::string(first, std::to_chars(first, last, value, format).ptr);
}

}  // namespace

std::optional<ParsedQuantity> parse_quantity(std::string_view text, const Unit& wanted, std::string& problem) {
  text = trimmed(text, blanks);
  if (starts_with(text, "+")) text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc::invalid_argument) {
    problem = "has no number";
    return std::nullopt;
  }
  if (error != std::errc() || !std::isfinite(number)) {
    problem = "is not a finite number";
    return std::nullopt;
  }
  text = trimmed(text.substr(std::size_t(end - text.data())), blanks);
  if (text.empty()) return ParsedQuantity{number + 0.0, false};
  const auto unit = parse_unit(text, problem);
  if (!unit) return std::nullopt;
  if (unit->dimension != wanted.dimension) {
    problem = "has the wrong kind of unit, " + std::string(text);
    return std::nullopt;
  }
  const double value = number * unit->numerator / unit->denominator + 0.0;
  if (!std::isfinite(value)) {
    problem = "is not a finite number";
    return std::nullopt;
  }
  return ParsedQuantity{value, true};
}

std::optional<double> parse_length_unit(std::string_view text) {
  const NamedUnit* unit = find_unit(trimmed(text, blanks));
  if (!unit || unit->dimension != units::length.dimension) return std::nullopt;
  return unit->numerator / unit->denominator;
}

std::string number_text(double value) {
  return shortest(value);
}
std::string number_text(float value) {
  return shortest(value);
}

}  // namespace umax
