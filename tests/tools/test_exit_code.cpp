#include "tests/support/catch.h"
#include "tools/system/exit_code.h"

using namespace umax;

TEST_CASE("each kind of fault has the exit code that scripts rely on") {
  CHECK(exit_code_of(Fault::usage) == 2);
  CHECK(exit_code_of(Fault::bad_data) == 65);
  CHECK(exit_code_of(Fault::not_found) == 66);
  CHECK(exit_code_of(Fault::unavailable) == 69);
  CHECK(exit_code_of(Fault::internal) == 70);
  CHECK(exit_code_of(Fault::cannot_create) == 73);
  CHECK(exit_code_of(Fault::io_error) == 74);
  CHECK(exit_code_of(Fault::try_again) == 75);
}
