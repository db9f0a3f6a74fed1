// What `umax help` and `umax help VERB` say.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace umax {

struct ExitCodeMeaning {
  const char* code;
  const char* meaning;
};
const std::vector<ExitCodeMeaning>& exit_codes();

/// Of the whole program.
std::string help_text();

/// Of one verb. Throws Error (usage) when there is no such verb.
std::string help_text(const std::string& verb);

/// Splits at empty lines.
std::vector<std::string> paragraphs_of(std::string_view text);

}  // namespace umax
