// Scripts that make a shell complete umax's verbs, options, values, scenes and files, from the tables of verbs and
// options.
#pragma once

#include <string>

namespace umax {

/// To be sourced, or put where bash-completion looks (completions/umax). Needs nothing but bash itself.
std::string bash_completion();

/// To be put as _umax into a folder of zsh's fpath.
std::string zsh_completion();

}  // namespace umax
