#include "tools/system/signals.h"

#include <array>
#include <csignal>

namespace umax {
namespace {

constexpr std::array<int, 3> watched{SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t noted = 0;
std::atomic<bool> stop = false;
int num_watches = 0;
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
  for (const int number : watched) {
    struct sigaction before{};
    sigaction(number, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);  // nohup stays nohup
  }
}

SignalWatch::~SignalWatch() {
  if (--num_watches > 0) return;
  for (const int number : watched) {
    struct sigaction now{};
    sigaction(number, nullptr, &now);
    if (now.sa_handler == note_signal) std::signal(number, SIG_DFL);
  }
}

const std::atomic<bool>& stop_flag() {
  return stop;
}

int stop_signal() {
  return noted;
}

}  // namespace umax
