#include "scenes/scene_key_table.h"

#include <fmt/format.h>

#include "scenes/scene_keys.h"

namespace umax {
namespace {

std::string header_of(const SceneSection& section) {
  if (section.name.empty()) return "Above the first table";
  return section.named ? "[" + section.name + ".NAME]" : "[" + section.name + "]";
}

// A | ends a cell, even inside code.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
  return text;
}

constexpr const char* keyframe_note =
    "A type with (k) also takes keyframes: { keys = [[t_s, value], …], interpolation = \"linear\" | \"smooth\" }.";

}  // namespace

std::string scene_key_table_markdown() {
  std::string text = std::string(keyframe_note) + "\n";
  for (const SceneSection& section : scene_sections()) {
    const std::string meaning = section.name.empty() ? "" : ": " + section.meaning;
    text += fmt::format("\n**`{}`**{}\n\n| key | type | default | meaning |\n|---|---|---|---|\n", header_of(section),
                        meaning);
    for (const SceneKey& key : section.keys)
      text += fmt::format("| `{}` | {} | {} | {} |\n", key.name, cell(key.type), cell(key.default_value),
                          cell(key.meaning));
  }
  return text;
}

std::string scene_key_help() {
  std::string text = std::string(keyframe_note) + "\n";
  for (const SceneSection& section : scene_sections()) {
    text += "\n" + header_of(section) + (section.name.empty() ? "" : "  " + section.meaning) + "\n";
    for (const SceneKey& key : section.keys)
      text +=
          fmt::format("  {:<26} {}\n  {:<26} {}; default {}\n", key.name, key.meaning, "", key.type, key.default_value);
  }
  return text;
}

}  // namespace umax
