#include "tests/support/catch.h"
TEST_CASE("$r placeholder") { CHECK(true); }
