#include "scenes/quantity.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>

#include "tests/support/catch.h"

using namespace umax;

namespace {

std::optional<double> value_of(const std::string& text, const Unit& unit) {
  std::string problem;
  const auto parsed = parse_quantity(text, unit, problem);
  return parsed ? std::optional(parsed->value) : std::nullopt;
}

std::string problem_of(const std::string& text, const Unit& unit) {
  std::string problem;
  CHECK_FALSE(parse_quantity(text, unit, problem));
  return problem;
}

}  // namespace

TEST_CASE("every quantity of the manual is read to the exact SI number", "[quantity]") {
  struct Row {
    const char* text;
    Unit unit;
    double value;
  };
  const auto row = GENERATE(values<Row>({
      {"500 kPa", units::pressure, 500e3},
      {"500kPa", units::pressure, 500e3},
      {"1.5 MPa", units::pressure, 1.5e6},
      {"2 GPa", units::pressure, 2e9},
      {"7 N/m^2", units::pressure, 7},
      {"100 J", units::energy, 100},
      {"0.1J", units::energy, 0.1},
      {"250 mJ", units::energy, 0.25},
      {"2 kJ", units::energy, 2000},
      {"3 N m", units::energy, 3},
      {"3 N*m", units::energy, 3},
      {"3 kg m^2/s^2", units::energy, 3},
      {"12 cm", units::length, 0.12},
      {"7 cm", units::length, 0.07},
      {"29 mm", units::length, 0.029},
      {"1 in", units::length, 0.0254},
      {"2 ft", units::length, 0.6096},
      {"20 %", units::ratio, 0.2},
      {"20%", units::ratio, 0.2},
      {"57 %", units::ratio, 0.57},
      {"150 m/m", units::ratio, 150},
      {"500 kg/m^3", units::density, 500},
      {"500 kg/m3", units::density, 500},
      {"500 kg/m³", units::density, 500},
      {"0.5 g/cm^3", units::density, 500},
      {"100 J/m^3", units::energy_density, 100},
      {"2 kJ/m^3", units::energy_density, 2000},
      {"3 Pa", units::energy_density, 3},
      {"90 deg", units::angle, 90},
      {"0.25 turn", units::angle, 90},
      {"-30°", units::angle, -30},
      {"2 m/s", units::speed, 2},
      {"36 km/h", units::speed, 10},
      {"-9.81 m/s^2", units::acceleration, -9.81},
      {"9.81 m s^-2", units::acceleration, 9.81},
      {"300 W", units::power, 300},
      {"1.2 kW", units::power, 1200},
      {"60 Hz", units::rate, 60},
      {"4 1/s", units::rate, 4},
      {"2 ms", units::time, 0.002},
      {"120 deg/s", units::spin, 120},
      {"+1e3 m", units::length, 1000},
      {"  5 m  ", units::length, 5},
      {"5", units::length, 5},
  }));
  CAPTURE(row.text);
  CHECK(value_of(row.text, row.unit) == row.value);
}

TEST_CASE("radians become degrees", "[quantity]") {
  CHECK(value_of("3.141592653589793 rad", units::angle).value() == Approx(180).epsilon(1e-15));
}

TEST_CASE("a quantity of another dimension is refused with its unit", "[quantity]") {
  CHECK(problem_of("5 m", units::pressure) == "has the wrong kind of unit, m");
  CHECK(problem_of("5 %", units::length) == "has the wrong kind of unit, %");
  CHECK(problem_of("5 deg/s", units::speed) == "has the wrong kind of unit, deg/s");
  CHECK(problem_of("5 kg", units::density) == "has the wrong kind of unit, kg");
  CHECK(problem_of("5 J", units::energy_density) == "has the wrong kind of unit, J");
}

TEST_CASE("a quantity that cannot be read says why", "[quantity]") {
  CHECK(problem_of("", units::length) == "has no number");
  CHECK(problem_of("cm", units::length) == "has no number");
  CHECK(problem_of("5 parsec", units::length) == "has the unknown unit parsec");
  CHECK(problem_of("5 kpa", units::pressure) == "has the unknown unit kpa");
  CHECK(problem_of("nan m", units::length) == "is not a finite number");
  CHECK(problem_of("inf", units::length) == "is not a finite number");
  CHECK(problem_of("1e999 m", units::length) == "is not a finite number");
  CHECK(problem_of("5 m^", units::length) == "has an exponent that cannot be read");
  CHECK(problem_of("5 m^0", units::length) == "has an exponent that cannot be read");
  CHECK(problem_of("5 m/", units::length) == "has a unit that cannot be read");
  CHECK(problem_of("5 m//s", units::speed) == "has a unit that cannot be read");
  CHECK(problem_of("5,5 m", units::length) == "has a unit that cannot be read");
  CHECK(problem_of("1 GPa GPa GPa GPa GPa GPa", units::pressure).find("wrong kind") != std::string::npos);
}

TEST_CASE("units of length are known by name", "[quantity]") {
  CHECK(parse_length_unit("cm") == 0.01);
  CHECK(parse_length_unit(" in ") == 0.0254);
  CHECK_FALSE(parse_length_unit("kg"));
  CHECK_FALSE(parse_length_unit(""));
}

TEST_CASE("number text reads back as the same number", "[quantity]") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    double value;
    float single;
    std::memcpy(&value, &bits, sizeof(value));
    std::memcpy(&single, &bits, sizeof(single));
    if (std::isfinite(value)) REQUIRE(value_of(number_text(value), units::ratio) == value);
    if (std::isfinite(single)) REQUIRE(float(value_of(number_text(single), units::ratio).value()) == single);
  }
  CHECK(number_text(-0.0) == "0");
  CHECK(number_text(500e3) == "500000");
  CHECK(number_text(0.1f) == "0.1");
}
