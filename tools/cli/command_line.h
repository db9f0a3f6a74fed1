// From the words of the command line to Options.
#pragma once

#include "tools/cli/options.h"

namespace umax {

/// Options and arguments may stand in any order. Throws Error (usage): unknown verb or option (naming the nearest), a
/// value that does not fit, an option that the verb does not take.
Options parse_command_line(int argc, const char* const* argv);

}  // namespace umax
