#include "tools/farm/farm_files.h"

#include <cassert>
#include <cstddef>
#include <utility>

namespace umax {

extern const std::pair<const char*, const char*> embedded_farm_files[];
extern const std::size_t num_embedded_farm_files;

std::string farm_file(const std::string& name) {
  for (std::size_t i = 0; i < num_embedded_farm_files; ++i)
    if (name == embedded_farm_files[i].first) return embedded_farm_files[i].second;
  assert(false);
  return {};
}

}  // namespace umax
