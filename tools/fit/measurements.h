// Force and deformation of a test specimen, as a laboratory writes them down, brought to stretch and nominal stress.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace umax {

enum class TestKind { uniaxial, compression, shear };

struct MeasurementOptions {
  TestKind test = TestKind::uniaxial;
  std::optional<double> length{};  // [m] of the specimen at rest (shear: its height), for columns of displacement
  std::optional<double> area{};    // [m^2] of its section at rest (shear: of a bonded face), for columns of force
};

struct MeasuredPoint {
  int line = 0;        // of the file
  double stretch = 0;  // [-] change of length over length, tension positive; shear: displacement over height, positive
  double stress = 0;   // [Pa] force over area at rest, signed likewise
  double lateral_stretch = std::numeric_limits<double>::quiet_NaN();  // [-] change of width over width; NaN: unknown
};

struct Measurements {
  std::string name;  // of the file
  TestKind test = TestKind::uniaxial;
  std::vector<MeasuredPoint> points;  // in the order of the file
  bool has_lateral = false;           // some point has a lateral stretch
  std::string reading;                // which columns were taken for what
  std::vector<std::string> warnings;  // what was ignored, or reinterpreted, and where
};

/// Columns by their usual names and units, as measured_columns.h has them: stretch or strain [%], stretch ratio,
/// displacement [mm]; force [N], stress [kPa]; lateral stretch [%], lateral stretch ratio. A column named "stretch"
/// without a unit is taken for a ratio where its numbers are one. Others are ignored and said. Rows that lack a number
/// are ignored and said. Throws Error (bad_data) that names line, column, value and remedy; Error (usage) for a
/// displacement without length, a force without area.
Measurements parse_measurements(std::string_view text, const std::string& name, const MeasurementOptions& options);

const char* test_name(TestKind test);

}  // namespace umax
