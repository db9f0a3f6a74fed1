// The table of all scene keys as text, for help and documentation.
#pragma once

#include <string>

namespace umax {

/// The page docs/keys.md in GitHub-flavoured Markdown: one table a section.
std::string scene_key_page();

/// Plain text for `umax help scene`.
std::string scene_key_help();

}  // namespace umax
