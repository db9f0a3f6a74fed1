#include "scenes/scene_key_table.h"

#include <fmt/format.h>

#include <cctype>

#include "scenes/scene_keys.h"

namespace umax {
namespace {

std::string header_of(const SceneSection& section) {
  if (section.name.empty()) return "Above the first table";
  if (!section.within.empty()) return "[" + section.header("NAME.PIN") + "]";
  return "[" + section.header("NAME") + "]";
}

// A | ends a cell, even inside code.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2)) text.insert(at, "\\");
  return text;
}

constexpr const char* keyframe_note =
    "A type with (k) also takes keyframes: { keys = [[t_s, value], …], interpolation = \"linear\" | \"smooth\" | "
    "\"hold\" }.";

constexpr const char* page_introduction = R"(# Scene keys

Every key that a scene file may have, with its unit, default and meaning. [scenes.md](scenes.md) shows how scenes are
written, [limits.md](limits.md) how limits are chosen.

A quantity is a number in SI units or a string with a unit: `"500 kPa"`, `"100 J"`, `"12 cm"`, `"20 %"`. Every key can be
set from the command line: `--set body.figure.limit.stretch=15%`. A key that does not exist is an error that names the
nearest one.

*This page is made from the table that the program itself reads scenes by. After a change of that table:
`UMAX_UPDATE_KEYS=1 build/release/bin/test_scenes "the page of scene keys*"`.*

)";

std::string heading_of(const SceneSection& section) {
  return section.name.empty() ? header_of(section) : fmt::format("`{}`", header_of(section));
}

}  // namespace

std::string scene_key_page() {
  std::string text = std::string(page_introduction) + keyframe_note + "\n";
  for (const SceneSection& section : scene_sections()) {
    std::string meaning = section.name.empty() ? "" : section.meaning + ".\n\n";
    if (!meaning.empty()) meaning[0] = char(std::toupper(static_cast<unsigned char>(meaning[0])));
    text += fmt::format("\n## {}\n\n{}| key | type | default | meaning |\n|---|---|---|---|\n", heading_of(section),
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
