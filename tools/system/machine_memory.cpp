#include "tools/system/machine_memory.h"

#include <fmt/format.h>
#include <sched.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <vector>

namespace umax {
namespace {

namespace fs = std::filesystem;

constexpr long long unlimited = std::numeric_limits<long long>::max();
constexpr double gib = 1 << 30, mib = 1 << 20;

/// The number after a name in a file of lines "NAME NUMBER ..."; nothing where it is not there.
std::optional<long long> number_after(const fs::path& path, const std::string& wanted) {
  std::ifstream file(path);
  for (std::string name, rest; file >> name; std::getline(file, rest)) {
    long long number = 0;
    if (name == wanted && file >> number) return number;
  }
  return std::nullopt;
}

/// The only number of a file; nothing for "max" or no file.
std::optional<long long> number_in(const fs::path& path) {
  std::ifstream file(path);
  long long number = 0;
  return file >> number ? std::optional(number) : std::nullopt;
}

/// What a cgroup leaves: pages of files that it holds make room when asked to.
long long left_by(const fs::path& group) {
  const auto limit = number_in(group / "memory.max");
  if (!limit) return unlimited;
  const long long held = number_in(group / "memory.current").value_or(0) -
                         number_after(group / "memory.stat", "inactive_file").value_or(0);
  return std::max(0LL, *limit - std::max(0LL, held));
}

/// Processors whose time a cgroup leaves: "150000 100000" are one and a half.
double processors_left_by(const fs::path& group) {
  std::ifstream file(group / "cpu.max");
  double quota = 0, period = 0;
  return file >> quota >> period && period > 0 ? quota / period : std::numeric_limits<double>::infinity();
}

/// Our cgroup and all above it.
std::vector<fs::path> groups_of_ours(const fs::path& root) {
  const fs::path top = root / "sys/fs/cgroup";
  std::vector<fs::path> groups{top};
  std::ifstream file(root / "proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("0::/")) continue;  // the others are of version 1
    for (fs::path group = line.substr(4); !group.empty(); group = group.parent_path()) groups.push_back(top / group);
  }
  return groups;
}

long long left_by_groups(const fs::path& root) {
  long long left = unlimited;
  for (const fs::path& group : groups_of_ours(root)) left = std::min(left, left_by(group));
  return left;
}

}  // namespace

double allowed_processors(const fs::path& root) {
  cpu_set_t ours;
  double allowed = sched_getaffinity(0, sizeof ours, &ours) == 0 ? CPU_COUNT(&ours) : 1;
  for (const fs::path& group : groups_of_ours(root)) allowed = std::min(allowed, processors_left_by(group));
  return allowed;
}

long long available_memory(const fs::path& root) {
  const auto kib = number_after(root / "proc/meminfo", "MemAvailable:");
  const long long machine = kib ? *kib * 1024 : 4LL << 30;  // where the system does not say
  return std::min(machine, left_by_groups(root));
}

std::optional<long long> parse_memory(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  std::string unit(end, text.data() + text.size());
  unit.erase(0, unit.find_first_not_of(' '));
  std::transform(unit.begin(), unit.end(), unit.begin(), [](unsigned char c) { return std::toupper(c); });
  constexpr std::string_view prefixes = "KMGT";
  const std::size_t power = unit.empty() ? std::string_view::npos : prefixes.find(unit.front());
  if (power != std::string_view::npos) {
    unit.erase(0, 1);
    if (unit == "IB") unit = "B";
    number = std::ldexp(number, 10 * (int(power) + 1));
  }
  if (!(unit.empty() || unit == "B") || !(number >= 1) || number > std::ldexp(1.0, 62)) return std::nullopt;
  return (long long)(number);
}

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int largest = 32 << 20;  // [bytes] of a block that glibc lets come from the heap
  mallopt(M_MMAP_THRESHOLD, largest);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

void give_back_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::string format_memory(double bytes) {
  const bool is_large = bytes >= gib;
  const double value = bytes / (is_large ? gib : mib);
  return fmt::format("{:.{}f} {}", value, is_large && value < 100 ? 1 : 0, is_large ? "GiB" : "MiB");
}

}  // namespace umax
