// Wall-clock time that something took.
#pragma once

#include <chrono>

namespace umax {

/// [s] from the start until now, by a clock that never goes back.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace umax
