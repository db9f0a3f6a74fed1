#include "scenes/scene_value.h"

#include <fmt/format.h>

#include "core/base/overloaded.h"
#include "scenes/quantity.h"

namespace umax {
namespace {

std::string full_text(const SceneValue& value) {
  const auto array_text = [](const SceneValue::Array& array) {
    std::string text = "[";
    for (const SceneValue& element : array) text += (text.size() > 1 ? ", " : "") + full_text(element);
    return text + "]";
  };
  const auto table_text = [](const SceneValue::Table& table) {
    std::string text = "{";
    for (const auto& [key, element] : table) text += (text.size() > 1 ? ", " : " ") + key + " = " + full_text(element);
    return text + " }";
  };
  return std::visit(Overloaded{
                        [](const SceneValue::Date&) { return std::string("a date"); },
                        [](bool flag) { return std::string(flag ? "true" : "false"); },
                        [](std::int64_t integer) { return std::to_string(integer); },
                        [](double number) { return number_text(number); },
                        [](const std::string& text) { return toml_string(text); },
                        array_text,
                        table_text,
                    },
                    value.data);
}

}  // namespace

std::string value_text(const SceneValue& value) {
  constexpr std::size_t longest = 80;
  std::string text = value.raw_text.empty() ? full_text(value) : value.raw_text;
  if (text.size() > longest) {
    std::size_t cut = longest;
    while (cut > 0 && (static_cast<unsigned char>(text[cut]) & 0xC0) == 0x80) --cut;  // not inside a UTF-8 character
    text = text.substr(0, cut) + "…";
  }
  return text;
}

std::string type_text(const SceneValue& value) {
  constexpr const char* names[] = {"a date",   "true or false", "an integer", "a number",
                                   "a string", "a list",        "a table"};
  return names[value.data.index()];
}

std::string where_text(const SourcePlace& place, const std::string& key) {
  if (place.is_override) return "--set " + key;
  const std::string line = place.line > 0 ? ":" + std::to_string(place.line) : "";
  return place.file + line + (key.empty() ? "" : ": " + key);
}

Error value_error(const SceneValue& value, const std::string& what, const std::string& remedy) {
  return Error(
      Fault::bad_data,
      {.where = where_text(value.place, value.key), .what = what, .value = value_text(value), .remedy = remedy});
}

std::string toml_string(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      result += std::string("\\") + c;
    else if (c == '\n')
      result += "\\n";
    else if (byte < 0x20 || byte == 0x7F)
      result += fmt::format("\\u{:04X}", byte);
    else
      result += c;
  }
  return result + "\"";
}

}  // namespace umax
