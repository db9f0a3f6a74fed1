#include "render/raster/llvmpipe.h"

#include <cstdlib>
#include <mutex>
#include <string>

namespace umax::raster {

void prepare_llvmpipe(int num_threads) {
  static std::once_flag once;
  std::call_once(once, [&] {
    ::unsetenv("GALLIUM_DRIVER");
    if (const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH"); width && std::string(width) == "512")
      ::unsetenv("LP_NATIVE_VECTOR_WIDTH");
    if (num_threads > 0) ::setenv("LP_NUM_THREADS", std::to_string(num_threads).c_str(), 1);
  });
}

}  // namespace umax::raster
