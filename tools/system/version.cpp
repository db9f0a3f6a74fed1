#include "tools/system/version.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "core/base/error.h"
#include "core/base/instruction_set.h"

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
  const bool has_512 = best_instruction_set() == InstructionSet::avx512;
  return built_for + (has_512 ? "; kernels of multigrids for AVX-512" : "; kernels of multigrids for AVX2 or less");
}

// what a function of OpenBLAS says; empty: there is none
std::string ask_blas(const char* function) {
  using Text = char* (*)();
  const auto found = reinterpret_cast<Text>(dlsym(RTLD_DEFAULT, function));
  return found ? found() : "";
}

// "OpenBLAS 0.3.21 (SkylakeX)": the processor that its kernels are for decides last bits
std::string blas() {
  const std::string config = ask_blas("openblas_get_config");
  const std::size_t end = config.find(' ', config.find(' ') + 1);
  return config.empty() ? "another BLAS than OpenBLAS"
                        : config.substr(0, end) + " (" + ask_blas("openblas_get_corename") + ")";
}

constexpr const char* isa_variable = "UMAX_ISA";
constexpr const char* blas_variable = "OPENBLAS_CORETYPE";
constexpr const char* avx2_core = "Haswell";  // whose kernels of OpenBLAS need AVX2 and FMA, and no more

// starts the program again with OpenBLAS's kernels for AVX2
void start_again(char** argv) {
  ::setenv(blas_variable, avx2_core, 1);
  ::execv("/proc/self/exe", argv);
  throw Error(Fault::unavailable,
              {.where = "--isa avx2",
               .what = "the program cannot start itself again (" + std::string(std::strerror(errno)) + ")",
               .remedy = fmt::format("start it with {}={} in the environment", blas_variable, avx2_core)});
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

std::string instruction_set_text() {
  return fmt::format("{} with {}", name_of(best_instruction_set()), blas());
}

void pin_instruction_set(const std::optional<std::string>& isa, char** argv) {
  const char* named = std::getenv(isa_variable);
  const std::string wanted = isa ? *isa : named ? named : "best";
  if (wanted != "avx2" && wanted != "best")
    throw Error(Fault::usage, {.where = isa_variable,
                               .what = "must be avx2 or best",
                               .value = "\"" + wanted + "\"",
                               .remedy = "leave it out for the best that the machine has"});
  ::setenv(isa_variable, wanted.c_str(), 1);  // for the programs that this one starts
  if (wanted == "best") return;
  const char* core = std::getenv(blas_variable);
  const bool has_openblas = !ask_blas("openblas_get_corename").empty();
  if (has_openblas && (!core || std::string(core) != avx2_core)) start_again(argv);
  use_at_most(InstructionSet::avx2);
}

}  // namespace umax
