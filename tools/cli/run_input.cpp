#include "tools/cli/run_input.h"

#include <algorithm>
#include <cctype>

#include "scenes/builtin_scenes.h"

namespace umax {
namespace fs = std::filesystem;

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) names.push_back(scene.name);
  return names;
}

InputKind kind_of_input(const std::string& input) {
  std::error_code error;
  if (fs::is_directory(input, error)) return InputKind::run;
  std::string ending = fs::path(input).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  if (ending.empty() || ending == ".toml") return InputKind::scene;
  return InputKind::mesh;
}

}  // namespace umax
