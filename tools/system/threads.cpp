#include "tools/system/threads.h"

#include <dlfcn.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <cfenv>
#include <mutex>
#include <optional>
#include <string>

#include "core/base/scoped_variable.h"

namespace umax {
namespace {

/// Whatever BLAS is installed: functions of OpenBLAS, which the reference and ATLAS do not have, are looked up.
struct BlasThreads {
  using Set = void (*)(int);
  using Get = int (*)();
  Set set = reinterpret_cast<Set>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  Get get = reinterpret_cast<Get>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  std::mutex mutex;
  int num_users = 0;  // that want one thread
  int found = 1;      // threads before the first of them
};

BlasThreads& blas_threads() {
  static BlasThreads threads;
  return threads;
}

/// How many threads the rasteriser's driver makes for itself; 0 would mean none beside the caller.
struct DriverThreads {
  std::mutex mutex;
  int num_users = 0;  // that want a number of theirs
  std::optional<ScopedVariable> variable;
};

DriverThreads& driver_threads() {
  static DriverThreads threads;
  return threads;
}

}  // namespace

OneBlasThread::OneBlasThread() {
  BlasThreads& blas = blas_threads();
  const std::lock_guard<std::mutex> lock(blas.mutex);
  if (blas.num_users++ > 0 || !blas.set) return;
  if (blas.get) blas.found = blas.get();
  if (blas.found != 1 || !blas.get) blas.set(1);
}

OneBlasThread::~OneBlasThread() {
  BlasThreads& blas = blas_threads();
  const std::lock_guard<std::mutex> lock(blas.mutex);
  if (--blas.num_users == 0 && blas.set && blas.found != 1) blas.set(blas.found);
}

struct ThreadLimit::Control {
  explicit Control(int threads) : limit(oneapi::tbb::global_control::max_allowed_parallelism, std::size_t(threads)) {}
  oneapi::tbb::global_control limit;
};

ThreadLimit::DriverLimit::DriverLimit(int threads) {
  DriverThreads& driver = driver_threads();
  const std::lock_guard<std::mutex> lock(driver.mutex);
  if (driver.num_users++ == 0) driver.variable.emplace("LP_NUM_THREADS", std::to_string(threads));
}

ThreadLimit::DriverLimit::~DriverLimit() {
  DriverThreads& driver = driver_threads();
  const std::lock_guard<std::mutex> lock(driver.mutex);
  if (--driver.num_users == 0) driver.variable.reset();
}

ThreadLimit::ThreadLimit(std::optional<int> threads)
    : count_(threads.value_or(oneapi::tbb::info::default_concurrency())) {
  control_ = std::make_unique<Control>(count_);
  if (threads) driver_.emplace(count_);
}

ThreadLimit::~ThreadLimit() = default;

void use_standard_floating_point() {
  std::fesetenv(FE_DFL_ENV);
}

StandardFloatingPoint::StandardFloatingPoint() {
  std::fegetenv(&found_);
  use_standard_floating_point();
}

StandardFloatingPoint::~StandardFloatingPoint() {
  std::fesetenv(&found_);
}

}  // namespace umax
