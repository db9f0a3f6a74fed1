// What asks the program to stop, Ctrl-C, termination and --deadline: noticed, so that what is complete can be kept.
#pragma once

#include <atomic>
#include <string>

namespace umax {

/// While one lives, the first SIGINT, SIGTERM or SIGHUP is only noted; a second one ends the program at once. Handlers are
/// afterwards what they were before.
class SignalWatch {
 public:
  SignalWatch();
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;
};

/// Becomes true when a signal asks us to stop.
const std::atomic<bool>& stop_flag();

/// Number of the signal that asks us to stop; 0: none. SIGALRM: the deadline is over.
int stop_signal();

/// From now on the program has so long [s] until SIGALRM asks it to stop.
void set_deadline(double seconds);

/// The exit code of what a signal has stopped: 128 + signal, 75 (go on later) for the deadline; 0 for 0.
int exit_code_after(int signal);

/// "stopped by signal 15; what is finished is kept, --resume goes on"
std::string stop_note(int signal);

/// For a program that goes on after a job that a signal has stopped: no signal asks us to stop any more.
void forget_stop();

}  // namespace umax
