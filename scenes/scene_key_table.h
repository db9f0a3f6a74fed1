// The table of scene keys as people read it.
#pragma once

#include <string>

namespace umax {

/// GitHub-flavoured Markdown, one table a section: for the README.
std::string scene_key_table_markdown();

/// Plain text for `umax help scene`.
std::string scene_key_help();

}  // namespace umax
