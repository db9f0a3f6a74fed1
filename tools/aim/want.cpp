#include "tools/aim/want.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "core/base/trimmed.h"
#include "scenes/quantity.h"

namespace umax {
namespace {

constexpr const char* example = "write for example --want 'height(figure) at 0.6 s = 85 %'";

struct MeasureName {
  const char* name;
  MeasureKind kind;
  bool takes_probe, takes_axis, takes_moment;
  const Unit& unit;
  bool takes_share;  // of a length
};

constexpr std::array measure_names{
    MeasureName{"height", MeasureKind::height, false, false, true, units::length, true},
    MeasureName{"width", MeasureKind::width, false, false, true, units::length, true},
    MeasureName{"length", MeasureKind::length, false, true, true, units::length, true},
    MeasureName{"tip", MeasureKind::tip, true, true, true, units::length, false},
    MeasureName{"squash", MeasureKind::squash, false, false, true, units::ratio, false},
    MeasureName{"stretch", MeasureKind::stretch, false, false, true, units::ratio, false},
    MeasureName{"rest", MeasureKind::rest, false, false, false, units::time, false},
    MeasureName{"bounce", MeasureKind::bounce, false, false, false, units::length, true}};

const MeasureName& name_of(MeasureKind kind) {
  return *std::find_if(measure_names.begin(), measure_names.end(), [&](const auto& one) { return one.kind == kind; });
}

using Words = std::vector<std::string>;

/// A want on its way from text: complaints say which it is.
struct Reader {
  const std::string& text;
  const Scene& scene;

  [[noreturn]] void refuse(const std::string& what, std::string_view value, const std::string& remedy) const {
    throw Error(Fault::usage, {.where = "--want " + text, .what = what, .value = std::string(value), .remedy = remedy});
  }

  double time(std::string_view word) const {
    std::string problem;
    if (const std::string_view number = trimmed(word); number.starts_with("frame ")) {
      const auto frame = parse_quantity(number.substr(6), units::ratio, problem);
      if (frame && frame->value >= 1) return (frame->value - 1) / scene.clip.fps;
    } else if (const auto time = parse_quantity(number, units::time, problem)) {
      if (time->value >= 0) return time->value;
      problem = "must not be negative";
    }
    refuse(problem.empty() ? "has no such time" : "a time " + problem, word, "write for example 0.6 s, or frame 37");
  }

  /// The one that is called so, or an error that names the nearest.
  std::size_t find(const char* kind, const std::string& name, const Words& names) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return std::size_t(found - names.begin());
    if (names.empty())
      refuse(fmt::format("the scene has no {}", kind), name,
             fmt::format("add a table [{}.NAME] to the scene, or measure something else", kind));
    refuse(fmt::format("names no {} of the scene", kind), name,
           fmt::format("did you mean {}? It has {}", nearest_word(name, names), fmt::join(names, ", ")));
  }
};

/// "a, b" -> a and b, without blanks.
Words split(std::string_view list) {
  Words parts;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    parts.emplace_back(trimmed(list.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

/// Takes a word off the front, if it stands there by itself.
bool take_word(std::string_view& text, std::string_view word) {
  text = trimmed(text);
  if (!text.starts_with(word) || (text.size() > word.size() && text[word.size()] != ' ')) return false;
  text = trimmed(text.substr(word.size()));
  return true;
}

const MeasureName& find_measure(const Reader& reader, std::string_view name) {
  Words names;
  for (const MeasureName& one : measure_names) {
    if (name == one.name) return one;
    names.emplace_back(one.name);
  }
  reader.refuse("there is no such measure", name,
                fmt::format("did you mean {}? There are {}", nearest_word(name, names), fmt::join(names, ", ")));
}

void read_arguments(const Reader& reader, const MeasureName& name, std::string_view list, Want& want) {
  Words names;
  for (const BodyDescription& body : reader.scene.bodies)
    if (!name.takes_probe) names.push_back(body.name);
  for (const ProbeDescription& probe : reader.scene.probes)
    if (name.takes_probe) names.push_back(probe.name);
  const char* kind = name.takes_probe ? "probe" : "body";
  const Words arguments = split(list);
  if (arguments.size() != (name.takes_axis ? 2u : 1u) || arguments.front().empty())
    reader.refuse(fmt::format("{} takes {}", name.name,
                              name.takes_axis ? fmt::format("a {} and an axis", kind) : fmt::format("one {}", kind)),
                  trimmed(list),
                  fmt::format("write for example {}({}{})", name.name, names.empty() ? "NAME" : names.front(),
                              name.takes_axis ? ", y" : ""));
  want.object = reader.find(kind, arguments.front(), names);
  if (!name.takes_axis) return;
  if (arguments[1] != "x" && arguments[1] != "y" && arguments[1] != "z")
    reader.refuse("there is no such axis", arguments[1], "give x, y or z");
  want.axis = arguments[1][0] - 'x';
}

/// "at 0.6 s", "at end", "from 0.2 s to 1 s" or nothing, behind the measure.
void read_span(const Reader& reader, std::string_view tail, double end, bool has_extreme, Want& want) {
  const std::string_view whole = tail;
  if (take_word(tail, "at")) {
    if (has_extreme) reader.refuse("a min or max is of a span, not of an instant", whole, "write from TIME to TIME");
    want.from = want.to = trimmed(tail) == "end" ? end : reader.time(tail);
    return;
  }
  if (take_word(tail, "from")) {
    const std::size_t to = tail.find(" to ");
    if (to == std::string_view::npos) reader.refuse("a span needs its end", whole, "write from 0.2 s to 1 s");
    want.from = reader.time(tail.substr(0, to));
    want.to = trimmed(tail.substr(to + 4)) == "end" ? end : reader.time(tail.substr(to + 4));
    if (!(want.from < want.to)) reader.refuse("a span must begin before it ends", whole, "write from 0.2 s to 1 s");
    if (!has_extreme) reader.refuse("of a span it is the least or the most", whole, "write min or max before it");
    return;
  }
  if (!tail.empty()) reader.refuse("is not understood", tail, "write at TIME, or from TIME to TIME");
  want.to = end;
}

void check_times(const Reader& reader, double end, const Want& want) {
  constexpr double rounding = 1e-9;  // [s]
  const ClipDescription& clip = reader.scene.clip;
  const double last = want.moment == WantMoment::instant ? want.from : want.to;
  if (last > end + rounding)
    reader.refuse("is after the end of the clip", fmt::format("{} s", number_text(last)),
                  fmt::format("the clip ends at {:.4g} s: give a time before, or --set clip.frames={}", end,
                              int(std::ceil(last * clip.fps - rounding)) + 1));
  if (want.moment != WantMoment::instant &&
      std::floor(want.to * clip.fps + rounding) < std::ceil(want.from * clip.fps - rounding))
    reader.refuse("no frame is in the span", fmt::format("{} s to {} s", number_text(want.from), number_text(want.to)),
                  fmt::format("there is a frame every {:.4g} s", 1 / clip.fps));
}

void read_value(const Reader& reader, const MeasureName& name, std::string_view word, Want& want) {
  std::string problem;
  const bool is_percentage = word.ends_with("%") || word.ends_with("percent");
  if (is_percentage && name.unit.dimension == units::length.dimension && !name.takes_share)
    reader.refuse(fmt::format("a percentage means nothing for {}", name.name), word, "give a length such as -30 cm");
  want.is_share = is_percentage && name.takes_share;
  const auto value = parse_quantity(word, want.is_share ? units::ratio : name.unit, problem);
  if (!value)
    reader.refuse("the value " + problem, word,
                  name.takes_share ? fmt::format("give a percentage, or a length such as {}", name.unit.example)
                                   : fmt::format("give for example {}", name.unit.example));
  if (name.kind != MeasureKind::tip && !(value->value > 0))
    reader.refuse("the value must be positive", word, "give one above 0");
  if (name.kind == MeasureKind::stretch && !value->has_unit && value->value > 1)
    reader.refuse("is a bare number above 1, which would be more than 100 %", word,
                  fmt::format("write {} % if that is meant", number_text(value->value)));
  want.value = value->value;
}

}  // namespace

Want parse_want(const std::string& text, const Scene& scene) {
  const Reader reader{text, scene};
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos) reader.refuse("says no value", "", example);
  std::string_view left = trimmed(std::string_view(text).substr(0, equals));
  Want want;
  want.text = text;
  want.name = std::string(left);
  const bool least = take_word(left, "min"), most = !least && take_word(left, "max"), has_extreme = least || most;
  const std::size_t open = left.find('('), close = left.find(')');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open)
    reader.refuse("names no measure and what it is of", left, example);
  const MeasureName& name = find_measure(reader, trimmed(left.substr(0, open)));
  want.measure = name.kind;
  read_arguments(reader, name, left.substr(open + 1, close - open - 1), want);
  const std::string_view tail = trimmed(left.substr(close + 1));
  if (!name.takes_moment && (has_extreme || !tail.empty()))
    reader.refuse(fmt::format("{} is of the whole clip", name.name), want.name, "leave min, max and times away");
  const double end = (scene.clip.frames - 1) / scene.clip.fps;
  read_span(reader, tail, end, has_extreme, want);
  if (name.takes_moment && !has_extreme && tail.empty())
    reader.refuse("does not say when", want.name, "write at TIME behind it, or min or max before it");
  want.moment = least ? WantMoment::least : most ? WantMoment::most : WantMoment::instant;
  if (!name.takes_moment) want.moment = WantMoment::whole;
  check_times(reader, end, want);
  read_value(reader, name, trimmed(std::string_view(text).substr(equals + 1)), want);
  return want;
}

std::string value_text(const Want& want, double value) {
  if (std::abs(value) < 1e-9) value = 0;  // what is left of rounding
  if (want.measure == MeasureKind::rest)
    return std::isinf(value) ? "not within the clip" : fmt::format("{:.4g} s", value);
  if (want.is_share || name_of(want.measure).unit.dimension == units::ratio.dimension)
    return fmt::format("{:.4g} %", 100 * value);
  return fmt::format("{:.4g} m", value);
}

int last_frame_of(const Want& want, const ClipDescription& clip) {
  constexpr double rounding = 1e-6;  // [frames]
  if (want.moment == WantMoment::whole) return clip.frames;
  return std::min(clip.frames, int(std::ceil(want.to * clip.fps - rounding)) + 1);
}

}  // namespace umax
