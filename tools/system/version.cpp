#include "tools/system/version.h"

#include <dlfcn.h>
#include <fmt/format.h>

namespace umax {

extern const char* const commit;  // written by cmake/write_commit.cmake

namespace {

#ifdef __clang__
constexpr const char* compiler = "clang " __clang_version__;
#else
constexpr const char* compiler = "GCC " __VERSION__;
#endif

std::string instruction_set() {
  const std::string built_for = *UMAX_ARCH ? UMAX_ARCH : "the compiler's default";
#ifdef __x86_64__
  const bool has_512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq");
  return built_for + (has_512 ? "; kernels of multigrids for AVX-512" : "; kernels of multigrids for AVX2 or less");
#else
  return built_for;
#endif
}

// "OpenBLAS 0.3.21 (SkylakeX)": the processor that its kernels are for decides last bits
std::string blas() {
  using Text = char* (*)();
  const auto ask = [](const char* function) -> std::string {
    const auto found = reinterpret_cast<Text>(dlsym(RTLD_DEFAULT, function));
    return found ? found() : "";
  };
  const std::string config = ask("openblas_get_config");
  const std::size_t end = config.find(' ', config.find(' ') + 1);
  return config.empty() ? "another BLAS than OpenBLAS"
                        : config.substr(0, end) + " (" + ask("openblas_get_corename") + ")";
}

}  // namespace

std::string version_text() {
  return UMAX_VERSION;
}

std::string version_report() {
  return fmt::format("umax {}\ncommit {}\nbuilt by {}, {}\ninstruction set {}\nlibraries {}, {}\n", version_text(),
                     *commit ? commit : "unknown", compiler, UMAX_BUILD_TYPE, instruction_set(), UMAX_LIBRARIES,
                     blas());
}

}  // namespace umax
