// Every reader is given what fuzzing begins with and all that it ever found: tests/fuzz/findings/TARGET/*.
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <map>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/seeds.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

const std::map<std::string, fuzz::Target> targets{
    {"scene", fuzz::read_scene},   {"quantity", fuzz::read_quantity}, {"presets", fuzz::read_presets},
    {"state", fuzz::read_state},   {"hexes", fuzz::read_hexes},       {"measurements", fuzz::read_measurements},
    {"mesh", fuzz::read_mesh},     {"cache", fuzz::read_cache},       {"picture", fuzz::read_picture},
    {"camera", fuzz::read_camera}, {"messages", fuzz::read_messages}};

/// No more memory than this beyond what the process has; what is taken beyond throws std::bad_alloc, which no reader may.
void limit_memory(std::size_t bytes) {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t most = pages * std::size_t(::sysconf(_SC_PAGESIZE)) + bytes;
  const rlimit limit{.rlim_cur = most, .rlim_max = RLIM_INFINITY};
  ::setrlimit(RLIMIT_AS, &limit);
}

double seconds_to_read(fuzz::Target target, const std::string& bytes) {
  const auto begin = std::chrono::steady_clock::now();
  target(bytes);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

TEST_CASE("no reader breaks on what fuzzing begins with") {
  std::map<std::string, int> given;
  for (const fuzz::Seed& seed : fuzz::seeds()) {
    CAPTURE(seed.target, seed.name);
    CHECK(seconds_to_read(targets.at(seed.target), seed.bytes) < 5);
    ++given[seed.target];
  }
  for (const auto& [name, target] : targets) CHECK(given[name] > 0);
}

TEST_CASE("no reader breaks on what fuzzing has ever found") {
  limit_memory(1u << 30);
  int num_files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(UMAX_SOURCE_DIR) / "tests/fuzz/findings")) {
    if (!entry.is_regular_file()) continue;
    CAPTURE(entry.path().string());
    CHECK(seconds_to_read(targets.at(entry.path().parent_path().filename()), file_text(entry.path())) < 5);
    ++num_files;
  }
  CHECK(num_files > 0);
}
