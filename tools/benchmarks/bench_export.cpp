// Figures of umax export: how long a cache takes that is long and fine, and that its memory does not grow with its frames.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/measured_command.h"
#include "tools/system/scratch_folder.h"

namespace umax {
namespace {

constexpr int num_around = 240, num_across = 180;  // 43,200 vertices

/// A torus of many vertices.
void write_torus(const std::filesystem::path& path) {
  constexpr double turn = 2 * std::numbers::pi;
  std::ofstream file(path);
  for (int i = 0; i < num_around; ++i)
    for (int j = 0; j < num_across; ++j) {
      const double u = turn * i / num_around, v = turn * j / num_across, radius = 0.7 + 0.3 * std::cos(v);
      file << fmt::format("v {} {} {}\n", radius * std::sin(u), 0.3 * std::sin(v), radius * std::cos(u));
    }
  const auto vertex = [](int i, int j) { return (i % num_around) * num_across + j % num_across + 1; };
  for (int i = 0; i < num_around; ++i)
    for (int j = 0; j < num_across; ++j)
      file << fmt::format("f {} {} {} {}\n", vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
}

constexpr const char* scene = R"([clip]
frames = 1000
[body.torus]
mesh = "torus.obj"
drop_height = 0.2
contact = "obstacles"
[obstacle.ground]
shape = "plane"
)";

BenchRows long_cache() {
  const ScratchFolder scratch("/dev/shm");  // a tmpfs
  write_torus(scratch.path() / "torus.obj");
  std::ofstream(scratch.path() / "long.toml") << scene;
  const std::filesystem::path run = scratch.path() / "run";
  measure_command({program(), "simulate", scratch.path() / "long.toml", "-o", run, "--quiet"});
  const auto exported = [&](const char* frames, const char* folder) {
    return measure_command({program(), "export", run, "--format", "pc2", "--bodies", "torus", "--frames", frames, "-o",
                            scratch.path() / folder, "--quiet"});
  };
  const Measurement few = exported("1-50", "few"), all = exported("1-1000", "all");
  const auto megabytes = double(std::filesystem::file_size(scratch.path() / "all/torus.pc2")) / 1e6;
  return {at_most("umax export: 1,000 frames of 43,200 vertices to PC2 on tmpfs", all.seconds, 5, "s",
                  fmt::format("{:.0f} MB", megabytes)),
          at_most("its peak memory over that of 50 frames", all.peak_bytes / few.peak_bytes, 1.05, "",
                  fmt::format("{:.0f} MiB", all.peak_bytes / 1048576))};
}

}  // namespace

std::vector<Benchmark> export_benchmarks() {
  return {{"export", false, false, long_cache}};
}

}  // namespace umax
