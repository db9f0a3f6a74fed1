#include "core/base/trimmed.h"
#include "tests/support/catch.h"

using namespace umax;

TEST_CASE("trimmed text has no blanks at its ends and keeps those inside", "[text]") {
  CHECK(trimmed(" \t a b\t") == "a b");
  CHECK(trimmed("a") == "a");
  CHECK(trimmed("").empty());
  CHECK(trimmed(" \t ").empty());
  CHECK(trimmed(" a\r\n") == "a\r\n");
  CHECK(trimmed(" a\r\n", " \r\n") == "a");
}
