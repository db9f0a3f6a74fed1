// What libFuzzer calls: UMAX_FUZZ_TARGET is one of the functions of fuzz_target.h.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  umax::fuzz::UMAX_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
