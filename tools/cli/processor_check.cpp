// Ends the program with a word on a processor that it is not built for. This file is compiled for every x86-64, and what it
// does comes before all other initialisers, which may use any instruction of the set that the rest is built for.
#include <unistd.h>

#include <cstring>

#ifdef UMAX_CHECKS_V3
namespace {

constexpr int unavailable = 69;  // exit_code_of(Fault::unavailable)
constexpr const char* message =
    "umax: error: this processor has no AVX2, FMA and BMI2 (x86-64-v3), which this build of umax needs; run it on one "
    "from "
    "2013 or later, or build it with -DUMAX_ARCH=x86-64\n";

[[gnu::constructor(101)]] void require_processor() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
      __builtin_cpu_supports("bmi2"))
    return;
  [[maybe_unused]] const auto written = write(STDERR_FILENO, message, std::strlen(message));
  _exit(unavailable);
}

}  // namespace
#endif
