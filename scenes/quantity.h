// Numbers with units in scene files, such as "500 kPa", "12 cm", "20 %" or "500 kg/m^3": read into SI units, with a
// check of the dimension.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace umax {

/// Exponents of the base units. Angles count as a dimension of their own, so that "2 m/s" is no "2 deg/s".
struct Dimension {
  int length = 0, mass = 0, time = 0, angle = 0;
  bool operator==(const Dimension&) const = default;
};

/// What a key measures: its dimension, the unit of a bare number, and a quantity to show in messages.
struct Unit {
  Dimension dimension;
  const char* symbol;    // unit of a bare number: SI, and degrees for angles; "" for ratios
  const char* accepted;  // some of the units that are understood
  const char* example;
};

namespace units {
inline constexpr Unit ratio{{}, "", "%", "20 %"};
inline constexpr Unit length{{.length = 1}, "m", "m, cm, mm, km, in, ft", "12 cm"};
inline constexpr Unit area{{.length = 2}, "m^2", "m^2, cm^2, mm^2, in^2", "25 mm^2"};
inline constexpr Unit time{{.time = 1}, "s", "s, ms, min", "0.5 s"};
inline constexpr Unit rate{{.time = -1}, "1/s", "1/s, Hz", "60 Hz"};
inline constexpr Unit speed{{.length = 1, .time = -1}, "m/s", "m/s, cm/s, km/h", "2 m/s"};
inline constexpr Unit acceleration{{.length = 1, .time = -2}, "m/s^2", "m/s^2", "9.81 m/s^2"};
inline constexpr Unit force{{.length = 1, .mass = 1, .time = -2}, "N", "N, mN, kN", "10 N"};
inline constexpr Unit stiffness{{.mass = 1, .time = -2}, "N/m", "N/m, kN/m, N/mm", "500 N/m"};
inline constexpr Unit pressure{{.length = -1, .mass = 1, .time = -2}, "Pa", "Pa, kPa, MPa, GPa, N/m^2", "500 kPa"};
inline constexpr Unit energy{{.length = 2, .mass = 1, .time = -2}, "J", "J, mJ, kJ, N m", "100 J"};
inline constexpr Unit energy_density{
    {.length = -1, .mass = 1, .time = -2}, "J/m^3", "J/m^3, kJ/m^3, J/cm^3", "100 J/m^3"};
inline constexpr Unit density{{.length = -3, .mass = 1}, "kg/m^3", "kg/m^3, g/cm^3", "500 kg/m^3"};
inline constexpr Unit angle{{.angle = 1}, "deg", "deg, rad, turn", "90 deg"};
inline constexpr Unit spin{{.time = -1, .angle = 1}, "deg/s", "deg/s, rad/s, turn/s", "90 deg/s"};
inline constexpr Unit power{{.length = 2, .mass = 1, .time = -3}, "W", "W, kW", "300 W"};
}  // namespace units

struct ParsedQuantity {
  double value = 0;  // in SI units, angles in degrees
  bool has_unit = false;
};

/// Reads "NUMBER UNIT" as a quantity of the wanted dimension; a number without a unit is in wanted.symbol. On failure
/// returns nothing and says in `problem` what is wrong ("has no number", "kg is a mass, not a length", …).
std::optional<ParsedQuantity> parse_quantity(std::string_view text, const Unit& wanted, std::string& problem);

/// Length of a unit named on its own, "cm" -> 0.01 [m]; nothing if it is not one of length.
std::optional<double> parse_length_unit(std::string_view text);

/// Shortest decimal text that reads back as the same number. Never "-0".
std::string number_text(double value);
std::string number_text(float value);

}  // namespace umax
