#include "tools/aim/key_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "core/base/error.h"
#include "core/base/trimmed.h"
#include "scenes/quantity.h"
#include "scenes/scene_file.h"
#include "tools/trials/snippet.h"

namespace umax {
namespace {

constexpr const char* example = "write for example --vary body.figure.limit.stretch=2%..60%";
constexpr double far_apart = 10;  // [-] high over low

[[noreturn]] void refuse(const std::string& where, const std::string& what, const std::string& value,
                         const std::string& remedy) {
  throw Error(Fault::usage, {.where = where, .what = what, .value = value, .remedy = remedy});
}

/// "20 %" -> 20 and "%".
struct EndText {
  double number = 0;
  std::string unit;
};

EndText read_end(const std::string& where, std::string_view word) {
  const std::string text(trimmed(word));
  char* rest = nullptr;
  const double number = std::strtod(text.c_str(), &rest);
  if (rest == text.c_str() || !std::isfinite(number)) refuse(where, "an end is no quantity", text, example);
  return {number, std::string(trimmed(rest))};
}

/// The number that TOML says: 0.2, or a quantity in quotes; nothing for anything else.
std::optional<double> number_of(const std::optional<std::string>& toml) {
  if (!toml) return std::nullopt;
  const char* begin = toml->c_str() + (toml->starts_with('"') ? 1 : 0);
  char* end = nullptr;
  const double number = std::strtod(begin, &end);
  if (end == begin || (*end != '\0' && *begin == *toml->c_str())) return std::nullopt;
  return number;
}

/// What the scene makes of a value of the key. Complaints are as of --vary.
std::optional<std::string> read_by_scene(const std::string& scene, std::vector<Override> settings,
                                         const std::string& key, const std::string& value) {
  settings.push_back({key, value});
  try {
    return value_in_scene(load_scene(scene, settings), key);
  } catch (const Error& error) {
    ErrorText text = error.text();
    if (text.where == "--set " + key) text.where = "--vary " + key;
    throw Error(error.fault(), text);
  }
}

std::string text_of(const EndText& end) {
  return number_text(end.number) + (end.unit.empty() ? "" : " " + end.unit);
}

}  // namespace

double KeyRange::value_at(double place) const {
  return logarithmic ? low * std::pow(high / low, place) : low + place * (high - low);
}

double KeyRange::place_of(double value) const {
  return logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
}

std::string value_text(const KeyRange& range, double place) {
  const double number = range.value_at(place) / range.unit_size;
  return text_of({std::strtod(fmt::format("{:.5g}", number).c_str(), nullptr), range.unit});
}

KeyRange parse_range(const std::string& text, const std::string& scene, const std::vector<Override>& settings) {
  const std::string where = "--vary " + text;
  const std::size_t equals = text.find('='), dots = text.find("..", std::min(equals, text.size()));
  KeyRange range;
  range.key = std::string(trimmed(text.substr(0, std::min(equals, text.size()))));
  if (equals == std::string::npos || range.key.empty() || dots == std::string::npos)
    refuse("--vary", "needs KEY=A..B", text, example);
  EndText low = read_end(where, std::string_view(text).substr(equals + 1, dots - equals - 1));
  EndText high = read_end(where, std::string_view(text).substr(dots + 2));
  if (low.unit.empty()) low.unit = high.unit;
  if (high.unit.empty()) high.unit = low.unit;
  if (high.unit != low.unit && low.number == 0) low.unit = high.unit;
  const auto read = [&](const EndText& end) {
    const auto number = number_of(read_by_scene(scene, settings, range.key, text_of(end)));
    if (!number)
      refuse("--vary " + range.key, "is no key of one number", text_of(end),
             "vary one that is, such as body.NAME.limit.stretch");
    return *number;
  };
  range.low = read(low);
  range.high = read(high);
  if (range.low == range.high) refuse(where, "both ends are the same", text_of(low), example);
  if (range.low > range.high) std::swap(range.low, range.high), std::swap(low, high);
  range.unit = high.unit;
  range.unit_size = range.high / high.number;
  if (high.number == 0) range.unit = low.unit, range.unit_size = range.low / low.number;
  range.logarithmic = range.low > 0 && range.high >= far_apart * range.low;
  read({range.value_at(0.382) / range.unit_size, range.unit});  // a whole number would not do
  const auto own = number_of(value_in_scene(load_scene(scene, settings), range.key));
  if (own && *own >= range.low && *own <= range.high) range.own = range.place_of(*own);
  return range;
}

}  // namespace umax
