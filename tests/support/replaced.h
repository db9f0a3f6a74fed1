// Texts spoilt in one place.
#pragma once

#include <string>

#include "tests/support/catch.h"

namespace umax::test {

/// The text with the first place of one part replaced by another; fails where there is none.
inline std::string replaced(std::string text, const std::string& part, const std::string& by) {
  const std::size_t at = text.find(part);
  REQUIRE(at != std::string::npos);
  return text.replace(at, part.size(), by);
}

}  // namespace umax::test
