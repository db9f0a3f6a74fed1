#include "tools/system/signals.h"

#include <fmt/format.h>
#include <sys/time.h>

#include <array>
#include <cmath>
#include <csignal>

#include "tools/system/exit_code.h"

namespace umax {
namespace {

constexpr std::array<int, 3> watched{SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t noted = 0;
std::atomic<bool> stop = false;
int num_watches = 0;
std::array<struct sigaction, watched.size()> found{};  // handlers before the first watch
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may not lock");

void note_signal(int number) {
  noted = number;
  stop = true;
}

}  // namespace

SignalWatch::SignalWatch() {
  if (num_watches++ > 0) return;  // a job within a larger one
  struct sigaction action{};
  action.sa_handler = note_signal;
  action.sa_flags = int(SA_RESETHAND) | SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < watched.size(); ++i) {
    sigaction(watched[i], nullptr, &found[i]);
    if (found[i].sa_handler != SIG_IGN) sigaction(watched[i], &action, nullptr);  // nohup stays nohup
  }
}

SignalWatch::~SignalWatch() {
  if (--num_watches > 0) return;
  for (std::size_t i = 0; i < watched.size(); ++i) {
    struct sigaction now{};
    sigaction(watched[i], nullptr, &now);
    const bool is_ours =
        now.sa_handler == note_signal || now.sa_handler == SIG_DFL;  // the latter once a signal has come
    if (is_ours) sigaction(watched[i], &found[i], nullptr);
  }
}

const std::atomic<bool>& stop_flag() {
  return stop;
}

int stop_signal() {
  return noted;
}

void set_deadline(double seconds) {
  struct sigaction action{};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGALRM, &action, nullptr);
  const double whole = std::floor(seconds);
  itimerval timer{};
  timer.it_value.tv_sec = time_t(whole);
  timer.it_value.tv_usec = suseconds_t(1e6 * (seconds - whole));
  setitimer(ITIMER_REAL, &timer, nullptr);
}

int exit_code_after(int signal) {
  if (signal == SIGALRM) return exit_code_of(Fault::try_again);
  return signal == 0 ? 0 : 128 + signal;
}

std::string stop_note(int signal) {
  const std::string cause = signal == SIGALRM ? "the deadline" : fmt::format("signal {}", signal);
  return fmt::format("stopped by {}; what is finished is kept, --resume goes on", cause);
}

void forget_stop() {
  noted = 0;
  stop = false;
}

}  // namespace umax
