// The scenes that come with the program, compiled in from scenes/*.toml.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace umax {

struct BuiltinScene {
  std::string name;
  std::string description;  // one line
  std::string_view text;    // the .toml file
};

/// In alphabetical order.
std::vector<BuiltinScene> builtin_scenes();

std::optional<BuiltinScene> find_builtin_scene(const std::string& name);

}  // namespace umax
