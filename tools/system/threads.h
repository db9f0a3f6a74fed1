// How many threads the libraries use, and the processor's floating-point mode that results depend on.
#pragma once

#include <memory>
#include <optional>

namespace umax {

/// Limits every library to this many threads while it lives; none: all cores. BLAS always gets one: its threads
/// would change the last bits.
class ThreadLimit {
 public:
  explicit ThreadLimit(std::optional<int> threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  int count() const { return count_; }

 private:
  struct Control;
  std::unique_ptr<Control> control_;
  int count_ = 1;
};

/// Sets rounding to nearest and denormal numbers on (as the standard has it) on the calling thread, from which TBB's
/// workers take it over. A renderer may work with other settings; a simulation must not.
void use_standard_floating_point();

}  // namespace umax
