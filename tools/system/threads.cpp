#include "tools/system/threads.h"

#include <dlfcn.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>

#include <cfenv>
#include <cstdlib>
#include <string>

namespace umax {
namespace {

/// Whatever BLAS is installed: the functions of OpenBLAS, of the reference and of ATLAS (which has none) are looked up.
void use_one_blas_thread() {
  using SetThreads = void (*)(int);
  if (void* function = dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) reinterpret_cast<SetThreads>(function)(1);
}

}  // namespace

struct ThreadLimit::Control {
  explicit Control(int threads) : limit(oneapi::tbb::global_control::max_allowed_parallelism, std::size_t(threads)) {}
  oneapi::tbb::global_control limit;
};

ThreadLimit::ThreadLimit(std::optional<int> threads)
    : count_(threads.value_or(oneapi::tbb::info::default_concurrency())) {
  control_ = std::make_unique<Control>(count_);
  // the rasteriser's driver has its own threads; 0 would mean none beside the caller
  if (threads) ::setenv("LP_NUM_THREADS", std::to_string(count_).c_str(), 1);
  use_one_blas_thread();
}

ThreadLimit::~ThreadLimit() = default;

void use_standard_floating_point() {
  std::fesetenv(FE_DFL_ENV);
}

}  // namespace umax
