// A value of a scene file or of --set, with where it stands, so that every message can point at it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "core/base/error.h"

namespace umax {

/// Where a value stands: a line of a scene file, or a --set of the command line.
struct SourcePlace {
  std::string file;                   // as the user named it; "--set" for overrides
  int line = 0;                       // from 1; 0: none
  std::filesystem::path folder = {};  // relative paths start here
  bool is_override = false;
};

struct SceneValue {
  using Array = std::vector<SceneValue>;
  struct Entry;                      // (a pair would need the whole SceneValue before it is complete)
  using Table = std::vector<Entry>;  // in the file's order
  struct Date {};                    // TOML has them, no key takes one

  std::variant<Date, bool, std::int64_t, double, std::string, Array, Table> data;
  SourcePlace place;
  std::string key;       // full dotted key, for messages
  std::string raw_text;  // what stood after the = of an override

  template <class T>
  const T* as() const {
    return std::get_if<T>(&data);
  }
};

struct SceneValue::Entry {
  std::string name;
  SceneValue value;
};

/// The value as TOML on one line, shortened when it is long.
std::string value_text(const SceneValue& value);

/// "a string", "a table", … for messages.
std::string type_text(const SceneValue& value);

/// "scene.toml:12: body.beam.limit.energy" or "--set body.beam.limit.energy".
std::string where_text(const SourcePlace& place, const std::string& key);

/// Error (bad_data) that points at the value.
Error value_error(const SceneValue& value, const std::string& what, const std::string& remedy);

/// TOML string literal with what needs escaping escaped.
std::string toml_string(const std::string& text);

}  // namespace umax
