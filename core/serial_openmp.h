// CHOLMOD's own threads, kept from those of the program.
#pragma once

#include <dlfcn.h>

namespace umax {

/// While one lives, CHOLMOD's OpenMP regions run on the calling thread: its fixed four threads spin against TBB's (2121
/// unknowns on 2 cores: 10.0 ms of processor time a step with them, 5.9 ms without). The runtime is whichever the
/// installed CHOLMOD has loaded.
class SerialOpenMp {
 public:
  SerialOpenMp() {
    if (get_levels && set_levels) levels_ = get_levels(), set_levels(0);
  }
  ~SerialOpenMp() {
    if (get_levels && set_levels) set_levels(levels_);
  }
  SerialOpenMp(const SerialOpenMp&) = delete;
  SerialOpenMp& operator=(const SerialOpenMp&) = delete;

 private:
  static inline const auto get_levels = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
  static inline const auto set_levels =
      reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
  int levels_ = 1;
};

}  // namespace umax
