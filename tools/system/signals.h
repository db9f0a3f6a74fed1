// Ctrl-C and termination: noticed, so that what is complete can be kept.
#pragma once

#include <atomic>

namespace umax {

/// While one lives, the first SIGINT, SIGTERM or SIGHUP is only noted; a second one ends the program at once.
class SignalWatch {
 public:
  SignalWatch();
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;
};

/// Becomes true when a signal asks us to stop.
const std::atomic<bool>& stop_flag();

/// Number of the signal that asks us to stop; 0: none.
int stop_signal();

}  // namespace umax
