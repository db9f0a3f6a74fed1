#include "scenes/toml_text.h"

// The packaged library, not the header-only form: that one asserts on some malformed tables instead of throwing.
#include <toml++/toml.h>

#include <algorithm>
#include <utility>

namespace umax {
namespace {

SceneValue convert(const toml::node& node, const SourcePlace& place) {
  SceneValue value;
  value.place = place;
  value.place.line = int(node.source().begin.line);
  if (const toml::table* table = node.as_table()) {
    SceneValue::Table entries;
    for (const auto& [key, element] : *table) entries.push_back({std::string(key.str()), convert(element, place)});
    // toml++ sorts keys by name: messages and results follow the file's order instead
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& a, const auto& b) { return a.value.place.line < b.value.place.line; });
    value.data = std::move(entries);
  } else if (const toml::array* array = node.as_array()) {
    SceneValue::Array elements;
    for (const toml::node& element : *array) elements.push_back(convert(element, place));
    value.data = std::move(elements);
  } else if (const auto* text = node.as_string()) {
    value.data = text->get();
  } else if (const auto* integer = node.as_integer()) {
    value.data = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    value.data = number->get();
  } else if (const auto* flag = node.as_boolean()) {
    value.data = flag->get();
  }
  return value;
}

// toml++ speaks of its own internals here and there; its first sentence is enough.
std::string first_line(std::string_view text) {
  return std::string(text.substr(0, text.find('\n')));
}

}  // namespace

SceneValue parse_toml(std::string_view text, const SourcePlace& place) {
  try {
    return convert(toml::parse(text, place.file), place);
  } catch (const toml::parse_error& error) {
    SourcePlace here = place;
    here.line = int(error.source().begin.line);
    throw Error(Fault::bad_data, {.where = where_text(here, ""),
                                  .what = "not valid TOML: " + first_line(error.description()),
                                  .remedy = "strings, such as quantities with a unit, stand in quotes"});
  }
}

SceneValue parse_override_value(const std::string& text, const SourcePlace& place) {
  SceneValue value;
  try {
    const toml::table table = toml::parse("value = " + text);
    if (table.size() == 1) value = convert(*table.get("value"), place);
  } catch (const toml::parse_error&) {
    value.data = text;  // a bare word, a path or a quantity
  }
  if (value.as<SceneValue::Date>()) value.data = text;
  value.place = place;
  value.raw_text = text;
  return value;
}

}  // namespace umax
