#include "tools/system/version.h"

namespace umax {

std::string version_text() {
  return UMAX_VERSION;
}

}  // namespace umax
