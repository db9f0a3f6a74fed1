#include "tools/trials/trial_names.h"

#include <algorithm>
#include <string_view>

namespace umax {
namespace {

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool ends_with_part(const std::string& key, const std::string& end) {
  return key == end || key.ends_with("." + end);
}

}  // namespace

std::string short_key(const std::string& key, const std::vector<std::string>& keys) {
  for (std::size_t dot = key.rfind('.'); dot != std::string::npos && dot > 0; dot = key.rfind('.', dot - 1)) {
    const std::string end = key.substr(dot + 1);
    const auto others = std::count_if(
        keys.begin(), keys.end(), [&](const std::string& other) { return other != key && ends_with_part(other, end); });
    if (others == 0) return end;
  }
  return key;
}

std::string folder_name(const std::string& text) {
  constexpr std::string_view kept = "=%.,-_+#";
  std::string name;
  for (const char c : text)
    if (is_plain(c) || kept.find(c) != std::string_view::npos)
      name += c;
    else if (c != ' ' && c != '"' && c != '\'')
      name += '_';
  return name.substr(0, 120);
}

std::string shell_word(const std::string& word) {
  constexpr std::string_view harmless = "%+,-./:=@_";
  if (!word.empty() && std::all_of(word.begin(), word.end(),
                                   [&](char c) { return is_plain(c) || harmless.find(c) != std::string_view::npos; }))
    return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace umax
