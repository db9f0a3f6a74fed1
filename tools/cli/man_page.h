// The manual page umax(1), made from the tables of verbs and options.
#pragma once

#include <string>

namespace umax {

/// The text that man and groff -man read.
std::string man_page();

}  // namespace umax
