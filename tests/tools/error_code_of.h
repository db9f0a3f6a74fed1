// Which exit code a call would end the program with.
#pragma once

#include "core/error.h"

namespace umax {

/// The exit code of the Error that `call` throws; 0 when it throws none.
template <class Call>
int error_code_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return int(error.exit_code());
  }
  return 0;
}

}  // namespace umax
