// Which version of the program this is.
#pragma once

#include <string>

namespace umax {

/// "0.1.0".
std::string version_text();

}  // namespace umax
