// The Python module: how long it takes to be there, and what a step costs through it.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "core/files/write_file.h"
#include "scenes/scene_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/measured_command.h"
#include "tools/setup/stepping.h"
#include "tools/system/scratch_folder.h"
#include "tools/system/subprocess.h"

namespace umax {
namespace {

// one hex with a limit that falls: the least that a step can be
constexpr const char* scene_text = R"(
[body.cube]
shape = "box"
size = [1, 1, 1]
cage.cells = [1, 1, 1]
cage.clip = "box"
limit.stretch = "10 %"
velocity = [0, 1, 0]
spin = [0, 90, 0]
)";
constexpr int num_steps = 500;

// [s] of a step, the best of ten times
double step_here(const std::filesystem::path& scene) {
  const Simulation simulation = set_up(load_scene(scene.string()));
  double best = 1e9;
  for (int round = 0; round < 10; ++round) {
    Stepping stepping = begin_stepping(simulation);
    State state = rest_state(simulation.model);
    advance(stepping, {}, state);  // makes the workspace
    state = rest_state(simulation.model);
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < num_steps; ++i) advance(stepping, {}, state);
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / num_steps);
  }
  return best;
}

struct InPython {
  double import_seconds = 0, step_seconds = 0;
};

InPython in_python(const std::filesystem::path& scene) {
  const char* source = std::getenv("UMAX_SOURCE");
  if (!source) throw std::runtime_error("tools/bench sets UMAX_SOURCE, the folder of the sources");
  const std::filesystem::path build = std::filesystem::path(program()).parent_path().parent_path();
  if (!std::filesystem::exists(build / "python/umax/__init__.py"))
    throw std::runtime_error("the Python module is not built: its packages are in tools/packages.python");
  const ProcessResult result = run_process({"env", "PYTHONPATH=" + (build / "python").string(), "/usr/bin/python3",
                                            std::string(source) + "/tools/benchmarks/bench_python.py", scene.string(),
                                            std::to_string(num_steps)});
  if (result.exit_code != 0) throw std::runtime_error(result.messages);
  InPython measured;
  std::istringstream(result.output) >> measured.import_seconds >> measured.step_seconds;
  return measured;
}

BenchRows python() {
  const ScratchFolder scratch;
  const std::filesystem::path scene = scratch.path() / "cube.toml";
  write_file(scene, scene_text);
  in_python(scene);  // reads what the disk has
  // in turns, as machines have moods
  double import_seconds = 1e9, there = 1e9, here = 1e9;
  for (int round = 0; round < 3; ++round) {
    here = std::min(here, step_here(scene));
    const InPython measured = in_python(scene);
    import_seconds = std::min(import_seconds, measured.import_seconds);
    there = std::min(there, measured.step_seconds);
  }
  return {at_most("import umax, once numpy is there", import_seconds, 0.3, "s"),
          at_most("a step of one hex: through Python over C++", there / here, 1.2, "x",
                  fmt::format("{:.1f} and {:.1f} us", 1e6 * there, 1e6 * here))};
}

}  // namespace

std::vector<Benchmark> python_benchmarks() {
  return {{"python", false, false, python}};
}

}  // namespace umax
