// What Mesa's software driver takes from the environment, put right while a context is made.
#pragma once

#include <mutex>
#include <optional>

#include "core/base/scoped_variable.h"

namespace umax::raster {

/// While one lives, no setting stands in the environment that makes llvmpipe crash and, when num_threads > 0, one that says
/// how many threads it has, to which the first context of the process listens. Afterwards the environment is as it was.
class DriverEnvironment {
 public:
  explicit DriverEnvironment(int num_threads);

 private:
  std::unique_lock<std::mutex> only_one_;
  ScopedVariable driver_;
  std::optional<ScopedVariable> vector_width_, threads_;
};

}  // namespace umax::raster
