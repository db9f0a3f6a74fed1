// How values of scene keys are read, checked, written and described: one small struct per kind of value.
//
// Each kind K has   using Value = …;
//                   Value read(const SceneValue&) const;     throws Error that points at the value
//                   std::string write(const Value&) const;   TOML; read(write(v)) == v to the last bit
//                   std::string type() const;                for the table of keys: "length [m], > 0"
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/track.h"
#include "core/base/types.h"
#include "scenes/quantity.h"
#include "scenes/scene_value.h"

namespace umax {

/// Allowed numbers; open ends are excluded themselves.
struct Range {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;

  bool contains(double value) const;
  std::string text() const;        // "> 0", "0 … 1", "" if everything is allowed
  std::string table_text() const;  // without bounds that only keep absurd numbers out
};
inline constexpr Range any_number{};
inline constexpr Range positive{.low = 0, .low_open = true};
inline constexpr Range not_negative{.low = 0};
inline constexpr Range zero_to_one{.low = 0, .high = 1};
inline constexpr double absurd_length = 1e6;  // [m]
inline constexpr Range any_length{.low = -absurd_length, .high = absurd_length};
inline constexpr Range positive_length{.low = 0, .high = absurd_length, .low_open = true};

/// "0.3", or a quantity in quotes.
struct NumberKind {
  using Value = double;
  Unit unit = units::ratio;
  Range range;
  Value read(const SceneValue& value) const;
  std::string write(Value number) const { return number_text(number); }
  std::string type() const;
};

/// Stretch limit: 0.2 or "20 %". A bare number above 1 is refused, since 20 is most likely meant as 20 %.
struct StretchKind {
  using Value = double;
  Value read(const SceneValue& value) const;
  std::string write(Value number) const;
  std::string type() const;
};

struct IntegerKind {
  using Value = int;
  int low = 0, high = std::numeric_limits<int>::max();
  Value read(const SceneValue& value) const;
  std::string write(Value number) const { return std::to_string(number); }
  std::string type() const;
};

struct FlagKind {
  using Value = bool;
  Value read(const SceneValue& value) const;
  std::string write(Value flag) const { return flag ? "true" : "false"; }
  std::string type() const { return "true or false"; }
};

struct TextKind {
  using Value = std::string;
  Value read(const SceneValue& value) const;
  std::string write(const Value& text) const { return toml_string(text); }
  std::string type() const { return "text"; }
};

/// Absolute once read: relative paths start at the scene file's folder, those of --set at the current one.
struct PathKind {
  using Value = std::filesystem::path;
  Value read(const SceneValue& value) const;
  std::string write(const Value& path) const { return toml_string(path.string()); }
  std::string type() const { return "path"; }
};

/// Path of a file that is there, else Error (not_found).
struct ExistingFileKind : PathKind {
  Value read(const SceneValue& value) const;
};

/// One of a few words, as text.
struct WordKind {
  using Value = std::string;
  std::vector<std::string> words;
  Value read(const SceneValue& value) const;
  std::string write(const Value& word) const { return toml_string(word); }
  std::string type() const;
};

/// One of a few words that stand for the values of an enum.
template <class E>
struct ChoiceKind {
  using Value = E;
  std::vector<std::pair<const char*, E>> choices;

  WordKind words() const {
    WordKind kind;
    for (const auto& [word, value] : choices) kind.words.push_back(word);
    return kind;
  }
  Value read(const SceneValue& value) const {
    const std::string chosen = words().read(value);
    for (const auto& [word, choice] : choices)
      if (chosen == word) return choice;
    return choices.front().second;
  }
  std::string write(const Value& value) const {
    for (const auto& [word, choice] : choices)
      if (choice == value) return toml_string(word);
    return toml_string(choices.front().first);
  }
  std::string type() const { return words().type(); }
};
template <class E>
ChoiceKind(std::vector<std::pair<const char*, E>>) -> ChoiceKind<E>;

/// Some of a few words, each once, in a list; or "all".
struct WordListKind {
  using Value = std::vector<std::string>;
  std::vector<std::string> words;
  Value read(const SceneValue& value) const;  // in the order of `words`
  std::string write(const Value& chosen) const;
  std::string type() const;
};

/// Such words that stand for the values of an enum.
template <class E>
struct ChoiceListKind {
  using Value = std::vector<E>;
  std::vector<std::pair<const char*, E>> choices;

  WordListKind words() const {
    WordListKind kind;
    for (const auto& [word, value] : choices) kind.words.push_back(word);
    return kind;
  }
  Value read(const SceneValue& value) const {
    Value chosen;
    for (const std::string& one : words().read(value))
      for (const auto& [word, choice] : choices)
        if (one == word) chosen.push_back(choice);
    return chosen;
  }
  std::string write(const Value& chosen) const {
    std::vector<std::string> texts;
    for (const auto& [word, choice] : choices)
      if (std::find(chosen.begin(), chosen.end(), choice) != chosen.end()) texts.push_back(word);
    return words().write(texts);
  }
  std::string type() const { return words().type(); }
};
template <class E>
ChoiceListKind(std::vector<std::pair<const char*, E>>) -> ChoiceListKind<E>;

/// [x, y, z], each a number or a quantity.
struct VectorKind {
  using Value = Vector3d;
  Unit unit = units::length;
  Range range;
  Value read(const SceneValue& value) const;
  std::string write(const Value& vector) const;
  std::string type() const;
};

/// [width, height] or "WIDTHxHEIGHT" in pixels.
struct SizeKind {
  using Value = std::pair<int, int>;
  int low = 1, high = 1;
  Value read(const SceneValue& value) const;
  std::string write(const Value& size) const;
  std::string type() const;
};

/// [r, g, b], linear Rec. 709, or "#rrggbb", sRGB. bounded: reflectance, at most 1.
struct ColorKind {
  using Value = Eigen::Vector3f;
  bool bounded = true;
  Value read(const SceneValue& value) const;
  std::string write(const Value& color) const;
  std::string type() const;
};

/// Lengths for red, green and blue, or one for all three.
struct RadiiKind {
  using Value = Eigen::Vector3f;
  Value read(const SceneValue& value) const;
  std::string write(const Value& radii) const;
  std::string type() const { return "[r, g, b] or one for all [m], each > 0"; }
};

/// "cm", or the metres of one unit.
struct LengthUnitKind {
  using Value = double;
  Value read(const SceneValue& value) const;
  std::string write(Value metres) const { return number_text(metres); }
  std::string type() const { return "unit of length"; }
};

struct Keyframe {
  double time = 0;  // [s]
  const SceneValue* value = nullptr;
};
/// The keys of { keys = [[t, v], …], interpolation = "linear" | "smooth" | "hold" }; throws unless times increase.
std::vector<Keyframe> read_keyframes(const SceneValue& value, Interpolation& interpolation);
std::string interpolation_text(Interpolation interpolation);

/// A value of another kind, or keyframes of it.
template <class Kind>
struct TrackKind {
  using Value = Track<typename Kind::Value>;
  Kind kind;

  Value read(const SceneValue& value) const {
    if (!value.as<SceneValue::Table>()) return Value(kind.read(value));
    Value track;
    for (const Keyframe& key : read_keyframes(value, track.interpolation)) {
      track.times.push_back(key.time);
      track.values.push_back(kind.read(*key.value));
    }
    if (track.is_constant()) return Value(track.values.front());
    return track;
  }
  std::string write(const Value& track) const {
    if (track.is_constant()) return kind.write(track.values.front());
    std::string text = "{ keys = [";
    for (std::size_t i = 0; i < track.times.size(); ++i)
      text += (i ? ", [" : "[") + number_text(track.times[i]) + ", " + kind.write(track.values[i]) + "]";
    return text + "], interpolation = " + toml_string(interpolation_text(track.interpolation)) + " }";
  }
  std::string type() const { return kind.type() + " (k)"; }
};
template <class Kind>
TrackKind(Kind) -> TrackKind<Kind>;

}  // namespace umax
