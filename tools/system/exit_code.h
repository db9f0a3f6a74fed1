// The program's exit codes: what each kind of fault becomes for the shell. 0 is success, 1 is `compare`: past the
// threshold.
#pragma once

#include "core/base/error.h"

namespace umax {

/// From sysexits.h where it has one.
constexpr int exit_code_of(Fault fault) {
  switch (fault) {
    case Fault::usage:
      return 2;
    case Fault::bad_data:
      return 65;
    case Fault::not_found:
      return 66;
    case Fault::unavailable:
      return 69;
    case Fault::internal:
      return 70;
    case Fault::cannot_create:
      return 73;
    case Fault::io_error:
      return 74;
    case Fault::try_again:
      return 75;
  }
  return 70;
}

}  // namespace umax
