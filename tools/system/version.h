// Which version of the program this is.
#pragma once

#include <string>

namespace umax {

/// "0.1.0".
std::string version_text();

/// Several lines: version, commit, compiler, instruction set, libraries.
std::string version_report();

}  // namespace umax
