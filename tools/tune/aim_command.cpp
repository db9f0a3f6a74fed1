#include "tools/tune/aim_command.h"

#include <algorithm>
#include <cstdlib>

#include "tools/trials/trial_names.h"

namespace umax {
namespace {

bool is_quantity(const std::string& value) {
  char* end = nullptr;
  std::strtod(value.c_str(), &end);
  return end != value.c_str() && value.find_first_of("[{\"'#") == std::string::npos;
}

bool can_be_aimed(const Variation& variation) {
  return variation.keys.size() == 1 && variation.values.size() > 1 &&
         std::all_of(variation.values.begin(), variation.values.end(), is_quantity);
}

/// "A..B" of the neighbours in the list.
std::string range_around(const std::vector<std::string>& values, const std::string& value) {
  const auto at = std::find(values.begin(), values.end(), value);
  const auto before = at == values.begin() ? at : at - 1, behind = at + 1 == values.end() ? at : at + 1;
  return *before + ".." + *behind;
}

}  // namespace

std::string aim_command(const std::string& scene, const std::vector<Override>& settings,
                        const std::vector<Variation>& variations, const SceneVariant& variant) {
  const auto aimed = std::find_if(variations.begin(), variations.end(), can_be_aimed);
  if (aimed == variations.end()) return "";
  std::string command = "umax aim " + shell_word(scene);
  const auto set = [&](const Override& setting) {
    command += " --set " + shell_word(setting.key + "=" + setting.value);
  };
  for (const Override& setting : settings) set(setting);
  for (const Override& setting : variant.settings)
    if (setting.key != aimed->keys.front()) set(setting);
  const std::string& value = variant.values[std::size_t(aimed - variations.begin())];
  return command + " --vary " + shell_word(aimed->keys.front() + "=" + range_around(aimed->values, value));
}

}  // namespace umax
