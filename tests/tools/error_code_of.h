// Which exit code a call would end the program with.
#pragma once

#include "tests/support/failure.h"

namespace umax {

/// The exit code of the Error that `call` throws; 0 when it throws none.
template <class Call>
int error_code_of(Call call) {
  return test::failure_of(call).code;
}

}  // namespace umax
