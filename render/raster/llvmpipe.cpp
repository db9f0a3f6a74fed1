#include "render/raster/llvmpipe.h"

#include <cstdlib>
#include <string>

namespace umax::raster {
namespace {

std::mutex environment_mutex;

}  // namespace

DriverEnvironment::DriverEnvironment(int num_threads)
    : only_one_(environment_mutex), driver_("GALLIUM_DRIVER", std::nullopt) {
  if (const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH"); width && std::string(width) == "512")
    vector_width_.emplace("LP_NATIVE_VECTOR_WIDTH", std::nullopt);
  if (num_threads > 0) threads_.emplace("LP_NUM_THREADS", std::to_string(num_threads));
}

}  // namespace umax::raster
