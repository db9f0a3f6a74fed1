// How many threads the libraries use, and the processor's floating-point mode that results depend on.
#pragma once

#include <cfenv>
#include <memory>
#include <optional>

namespace umax {

/// While one lives, BLAS has one thread: more would change the last bits. Once the last is gone it has what it had.
class OneBlasThread {
 public:
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;
};

/// Limits every library to this many threads while it lives; none: all cores. BLAS always gets one. The rasteriser's driver
/// is told by the environment, which is afterwards as it was.
class ThreadLimit {
 public:
  explicit ThreadLimit(std::optional<int> threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  int count() const { return count_; }

 private:
  struct Control;
  struct DriverLimit {
    explicit DriverLimit(int threads);
    ~DriverLimit();
    DriverLimit(const DriverLimit&) = delete;
    DriverLimit& operator=(const DriverLimit&) = delete;
  };
  OneBlasThread blas_;
  std::unique_ptr<Control> control_;
  std::optional<DriverLimit> driver_;
  int count_ = 1;
};

/// use_standard_floating_point() while it lives, on the thread that makes it; afterwards the mode is what it was.
class StandardFloatingPoint {
 public:
  StandardFloatingPoint();
  ~StandardFloatingPoint();
  StandardFloatingPoint(const StandardFloatingPoint&) = delete;
  StandardFloatingPoint& operator=(const StandardFloatingPoint&) = delete;

 private:
  std::fenv_t found_;
};

/// Sets rounding to nearest and denormal numbers on (as the standard has it) on the calling thread, from which TBB's
/// workers take it over. A renderer may work with other settings; a simulation must not.
void use_standard_floating_point();

}  // namespace umax
