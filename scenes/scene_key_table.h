// The table of all scene keys as text, for help and documentation.
#pragma once

#include <string>

namespace umax {

/// GitHub-flavoured Markdown, one table a section: for the README.
std::string scene_key_table_markdown();

/// Plain text for `umax help scene`.
std::string scene_key_help();

}  // namespace umax
