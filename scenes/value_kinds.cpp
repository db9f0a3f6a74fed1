#include "scenes/value_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/base/nearest_word.h"
#include "core/base/srgb.h"

namespace umax {
namespace {

std::string unit_remedy(const Unit& unit) {
  if (unit.symbol[0] == '\0') return fmt::format("give a number, or a quantity such as \"{}\"", unit.example);
  return fmt::format("give a number in {}, or a quantity such as \"{}\" (units: {})", unit.symbol, unit.example,
                     unit.accepted);
}

// Number or quantity, not yet checked against a range.
ParsedQuantity read_quantity(const SceneValue& value, const Unit& unit) {
  double number = 0;
  if (const auto* integer = value.as<std::int64_t>()) {
    number = double(*integer);
  } else if (const auto* real = value.as<double>()) {
    number = *real + 0.0;
  } else if (const auto* text = value.as<std::string>()) {
    std::string problem;
    const auto parsed = parse_quantity(*text, unit, problem);
    if (!parsed) throw value_error(value, problem, unit_remedy(unit));
    // a file's "500" leaves open what is meant; on the command line quotes get lost
    if (!parsed->has_unit && !value.place.is_override) throw value_error(value, "has no unit", unit_remedy(unit));
    return *parsed;
  } else {
    throw value_error(value, "must be a number, but is " + type_text(value), unit_remedy(unit));
  }
  if (!std::isfinite(number)) throw value_error(value, "is not a finite number", unit_remedy(unit));
  return {number, false};
}

std::string range_problem(const Range& range, const Unit& unit) {
  const std::string symbol = unit.symbol[0] == '\0' ? "" : std::string(" ") + unit.symbol;
  if (range.low == 0 && !std::isfinite(range.high)) return range.low_open ? "must be positive" : "must not be negative";
  return "must be " + range.text() + symbol;
}

double read_number(const SceneValue& value, const Unit& unit, const Range& range) {
  const double number = read_quantity(value, unit).value;
  if (range.contains(number)) return number;
  const bool is_ratio = unit.symbol[0] == '\0';
  throw value_error(value, range_problem(range, unit), is_ratio ? "give a number " + range.text() : unit_remedy(unit));
}

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + toml_string(word);
  return text;
}

const SceneValue::Array& array_of(const SceneValue& value, std::size_t size, const std::string& remedy) {
  const auto* array = value.as<SceneValue::Array>();
  if (!array) throw value_error(value, "must be a list, but is " + type_text(value), remedy);
  if (array->size() != size)
    throw value_error(value, fmt::format("must have {} numbers, but has {}", size, array->size()), remedy);
  return *array;
}

int read_integer(const SceneValue& value, int low, int high) {
  const std::string remedy = fmt::format("give a whole number from {} to {}", low, high);
  std::int64_t number = 0;
  if (const auto* integer = value.as<std::int64_t>()) {
    number = *integer;
  } else if (const auto* real = value.as<double>(); real && *real == std::floor(*real) && std::abs(*real) < 1e15) {
    number = std::int64_t(*real);
  } else {
    throw value_error(value, "must be a whole number", remedy);
  }
  if (number < low || number > high) throw value_error(value, fmt::format("must be {} … {}", low, high), remedy);
  return int(number);
}

float linear_from_code(unsigned code) {
  return float(linear_from_srgb((code & 255) / 255.0));
}

}  // namespace

bool Range::contains(double value) const {
  return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
}

std::string Range::table_text() const {
  constexpr double sanity = 1e5;
  Range shown = *this;
  if (low <= -sanity) shown.low = any_number.low;
  if (high >= sanity) shown.high = any_number.high;
  return shown.text();
}

std::string Range::text() const {
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  if (!has_low && !has_high) return "";
  if (!has_high) return (low_open ? "> " : ">= ") + number_text(low);
  if (!has_low) return (high_open ? "< " : "<= ") + number_text(high);
  if (!low_open && !high_open) return number_text(low) + " … " + number_text(high);
  return (low_open ? "> " : ">= ") + number_text(low) + " and " + (high_open ? "< " : "<= ") + number_text(high);
}

double NumberKind::read(const SceneValue& value) const {
  return read_number(value, unit, range);
}

std::string NumberKind::type() const {
  const std::string symbol = unit.symbol[0] == '\0' ? "number" : fmt::format("number [{}]", unit.symbol);
  return range.table_text().empty() ? symbol : symbol + ", " + range.table_text();
}

double StretchKind::read(const SceneValue& value) const {
  const ParsedQuantity stretch = read_quantity(value, units::ratio);
  const std::string remedy = "give a stretch such as \"20 %\", or the fraction 0.2";
  if (!(stretch.value > 0)) throw value_error(value, "must be positive", remedy);
  if (stretch.value > 10) throw value_error(value, "must be at most 1000 %", remedy);
  if (!stretch.has_unit && stretch.value > 1)
    throw value_error(value, "is a bare number above 1, which would be more than 100 %",
                      fmt::format("write \"{} %\" if that is meant", number_text(stretch.value)));
  return stretch.value;
}

std::string StretchKind::write(double number) const {
  return number > 1 ? toml_string(number_text(number) + " m/m") : number_text(number);
}

std::string StretchKind::type() const {
  return "fraction or percentage, > 0";
}

int IntegerKind::read(const SceneValue& value) const {
  return read_integer(value, low, high);
}

std::string IntegerKind::type() const {
  return high == std::numeric_limits<int>::max() ? fmt::format("integer, >= {}", low)
                                                 : fmt::format("integer, {} … {}", low, high);
}

bool FlagKind::read(const SceneValue& value) const {
  if (const bool* flag = value.as<bool>()) return *flag;
  throw value_error(value, "must be true or false, but is " + type_text(value), "write true or false, without quotes");
}

std::string TextKind::read(const SceneValue& value) const {
  if (const auto* text = value.as<std::string>()) return *text;
  if (value.place.is_override && !value.raw_text.empty()) return value.raw_text;
  throw value_error(value, "must be text, but is " + type_text(value), "write it in quotes");
}

std::filesystem::path PathKind::read(const SceneValue& value) const {
  const std::string text = TextKind().read(value);
  if (text.empty() || text.find('\0') != std::string::npos)
    throw value_error(value, "must be a path", "give the path of a file");
  return std::filesystem::absolute(value.place.folder / text).lexically_normal();
}

std::filesystem::path ExistingFileKind::read(const SceneValue& value) const {
  const std::filesystem::path path = PathKind::read(value);
  std::error_code failed;
  if (std::filesystem::is_regular_file(path, failed)) return path;
  throw Error(Fault::not_found, {.where = where_text(value.place, value.key),
                                 .what = "no such file",
                                 .value = path.string(),
                                 .remedy = "check the path"});
}

std::string WordKind::read(const SceneValue& value) const {
  const auto* text = value.as<std::string>();
  if (!text && value.place.is_override) text = &value.raw_text;  // --set solver.energy=true
  if (!text)
    throw value_error(value, "must be one of " + join(words) + ", but is " + type_text(value), "write one in quotes");
  if (std::find(words.begin(), words.end(), *text) != words.end()) return *text;
  throw value_error(value, "must be one of " + join(words), "did you mean \"" + nearest_word(*text, words) + "\"?");
}

std::string WordKind::type() const {
  return join(words);
}

std::vector<std::string> WordListKind::read(const SceneValue& value) const {
  const std::string remedy = "give a list of these, or \"all\": " + join(words);
  const auto* text = value.as<std::string>();
  if (!text && value.place.is_override && !value.as<SceneValue::Array>()) text = &value.raw_text;
  if (text && *text == "all") return words;
  const auto* array = value.as<SceneValue::Array>();
  if (!array) throw value_error(value, "must be a list of words, but is " + type_text(value), remedy);
  std::vector<std::string> given;
  for (const SceneValue& one : *array) given.push_back(WordKind{words}.read(one));
  std::vector<std::string> chosen;
  for (const std::string& word : words)
    if (std::find(given.begin(), given.end(), word) != given.end()) chosen.push_back(word);
  if (chosen.size() != given.size()) throw value_error(value, "names one twice", remedy);
  return chosen;
}

std::string WordListKind::write(const std::vector<std::string>& chosen) const {
  return "[" + join(chosen) + "]";
}

std::string WordListKind::type() const {
  return "list of " + join(words) + "; or \"all\"";
}

Vector3d VectorKind::read(const SceneValue& value) const {
  const SceneValue::Array& array = array_of(value, 3, "give [x, y, z]");
  return {read_number(array[0], unit, range), read_number(array[1], unit, range), read_number(array[2], unit, range)};
}

std::string VectorKind::write(const Vector3d& vector) const {
  return fmt::format("[{}, {}, {}]", number_text(vector[0]), number_text(vector[1]), number_text(vector[2]));
}

std::string VectorKind::type() const {
  const std::string symbol = unit.symbol[0] == '\0' ? "[x, y, z]" : fmt::format("[x, y, z] [{}]", unit.symbol);
  return range.table_text().empty() ? symbol : symbol + ", each " + range.table_text();
}

std::pair<int, int> SizeKind::read(const SceneValue& value) const {
  if (const auto* text = value.as<std::string>()) {
    int width = 0, height = 0;
    const char* const end = text->data() + text->size();
    const auto first = std::from_chars(text->data(), end, width);
    const bool has_x = first.ec == std::errc() && first.ptr != end && *first.ptr == 'x';
    const bool is_size = has_x && std::from_chars(first.ptr + 1, end, height).ptr == end;
    if (is_size && std::min(width, height) >= low && std::max(width, height) <= high) return {width, height};
    throw value_error(value, fmt::format("must be two numbers from {} to {}", low, high), "write it as \"1280x720\"");
  }
  const SceneValue::Array& array = array_of(value, 2, "give [width, height] in pixels");
  return {read_integer(array[0], low, high), read_integer(array[1], low, high)};
}

std::string SizeKind::write(const Value& size) const {
  return fmt::format("[{}, {}]", size.first, size.second);
}

std::string SizeKind::type() const {
  return fmt::format("[width, height] [px], each {} … {}", low, high);
}

Eigen::Vector3f ColorKind::read(const SceneValue& value) const {
  const std::string remedy = "give [r, g, b], linear, or \"#rrggbb\"";
  if (const auto* text = value.as<std::string>()) {
    unsigned code = 0;
    const char* const end = text->data() + text->size();
    const bool is_hash = text->size() == 7 && text->front() == '#';
    if (!is_hash || std::from_chars(text->data() + 1, end, code, 16).ptr != end)
      throw value_error(value, "is not a colour", remedy);
    return {linear_from_code(code >> 16), linear_from_code(code >> 8), linear_from_code(code)};
  }
  const Range range = bounded ? zero_to_one : Range{.low = 0, .high = 1e9};
  const SceneValue::Array& array = array_of(value, 3, remedy);
  Eigen::Vector3f color;
  for (int i = 0; i < 3; ++i) color[i] = float(read_number(array[std::size_t(i)], units::ratio, range));
  return color;
}

std::string ColorKind::write(const Value& color) const {
  return fmt::format("[{}, {}, {}]", number_text(color[0]), number_text(color[1]), number_text(color[2]));
}

std::string ColorKind::type() const {
  return bounded ? "[r, g, b] linear, each 0 … 1, or \"#rrggbb\"" : "[r, g, b] linear, each >= 0, or \"#rrggbb\"";
}

Eigen::Vector3f RadiiKind::read(const SceneValue& value) const {
  if (!value.as<SceneValue::Array>())
    return Eigen::Vector3f::Constant(float(read_number(value, units::length, positive_length)));
  const SceneValue::Array& array = array_of(value, 3, "give [r, g, b], or one length for all three");
  Eigen::Vector3f radii;
  for (int i = 0; i < 3; ++i) radii[i] = float(read_number(array[std::size_t(i)], units::length, positive_length));
  return radii;
}

std::string RadiiKind::write(const Value& radii) const {
  return fmt::format("[{}, {}, {}]", number_text(radii[0]), number_text(radii[1]), number_text(radii[2]));
}

double LengthUnitKind::read(const SceneValue& value) const {
  if (const auto* text = value.as<std::string>())
    if (const auto metres = parse_length_unit(*text)) return *metres;
  const std::string remedy = "give a unit such as \"m\", \"cm\", \"mm\" or \"in\", or its length in metres";
  if (value.as<std::string>()) throw value_error(value, "is not a unit of length", remedy);
  const double metres = read_quantity(value, units::length).value;
  if (!(metres >= 1e-9 && metres <= 1e9)) throw value_error(value, "must be 1e-9 … 1e9 m", remedy);
  return metres;
}

std::vector<Keyframe> read_keyframes(const SceneValue& value, Interpolation& interpolation) {
  const std::string remedy = "write { keys = [[0, 1], [\"2 s\", 3]], interpolation = \"linear\" }";
  std::vector<Keyframe> keyframes;
  for (const auto& [name, entry] : *value.as<SceneValue::Table>()) {
    if (name == "interpolation") {
      const ChoiceKind<Interpolation> kind{
          {{"linear", Interpolation::linear}, {"smooth", Interpolation::smooth}, {"hold", Interpolation::hold}}};
      interpolation = kind.read(entry);
      continue;
    }
    if (name != "keys") throw value_error(entry, "unknown part of keyframes", remedy);
    const auto* keys = entry.as<SceneValue::Array>();
    if (!keys) throw value_error(entry, "must be a list of [time, value]", remedy);
    for (const SceneValue& key : *keys) {
      const SceneValue::Array& pair = array_of(key, 2, remedy);
      keyframes.push_back({read_number(pair[0], units::time, any_number), &pair[1]});
      if (keyframes.size() > 1 && !(keyframes.back().time > keyframes[keyframes.size() - 2].time))
        throw value_error(key, "is not later than the key before it", "sort the keys by time, each time once");
    }
  }
  if (keyframes.empty()) throw value_error(value, "has no keys", remedy);
  return keyframes;
}

std::string interpolation_text(Interpolation interpolation) {
  if (interpolation == Interpolation::hold) return "hold";
  return interpolation == Interpolation::smooth ? "smooth" : "linear";
}

}  // namespace umax
