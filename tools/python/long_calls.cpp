// What long work does to Python, and Python to it: its lock, its signals, the state of libraries that it shares.
#include <pybind11/pybind11.h>

#include <chrono>
#include <csignal>
#include <optional>

#include "tools/python/bindings.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace py = pybind11;

namespace umax {

void long_call(const std::function<void()>& work, std::optional<int> threads) {
  const py::gil_scoped_release unlocked;
  const StandardFloatingPoint standard;
  const OneBlasThread one_blas_thread;
  std::optional<ThreadLimit> limit;
  if (threads) limit.emplace(*threads);
  work();
}

void look_for_signals() {
  using Clock = std::chrono::steady_clock;
  static thread_local Clock::rep last = 0;
  const Clock::rep now = Clock::now().time_since_epoch().count();
  constexpr Clock::rep interval = std::chrono::duration_cast<Clock::duration>(std::chrono::milliseconds(50)).count();
  if (now - last < interval) return;
  last = now;
  const py::gil_scoped_acquire locked;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void pass_on_signal() {
  const int signal = stop_signal();
  if (signal == 0) return;
  forget_stop();
  std::raise(signal);
  if (PyErr_CheckSignals() == 0) PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw py::error_already_set();
}

void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

}  // namespace umax
