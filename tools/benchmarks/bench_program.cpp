// Figures of the program as a whole: run from outside, in folders of its own.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "core/files/write_file.h"
#include "render/image/flip.h"
#include "render/image/image_io.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/measured_command.h"
#include "tools/reproduce/experiments.h"
#include "tools/run/run_record.h"
#include "tools/run/steps_csv.h"
#include "tools/system/scratch_folder.h"

namespace umax {
namespace {

double gibibytes(double bytes) {
  return bytes / (1024.0 * 1024.0 * 1024.0);
}

BenchRows demo() {
  const ScratchFolder scratch;
  const Measurement outcome = measure_command({program(), "run", "figure", "-o", scratch.path() / "demo", "--quiet"});
  return {at_most("figure: the demo's clip, 640x360", outcome.seconds / 60, 5, "min",
                  fmt::format("peak {:.2f} GiB", gibibytes(outcome.peak_bytes)))};
}

// the filtered frame against one with so many samples that filtering is idle
BenchRows noise() {
  const ScratchFolder scratch;
  measure_command({program(), "simulate", "figure", "-o", scratch.path() / "demo", "--frames", "1-60", "--quiet"});
  measure_command(
      {program(), "render", scratch.path() / "demo", "--frames", "60", "-o", scratch.path() / "few", "--quiet"});
  measure_command({program(), "render", scratch.path() / "demo", "--frames", "60", "-o", scratch.path() / "many",
                   "--samples", "1024", "--set", "render.denoise=false", "--quiet"});
  const Image8 few = read_png8(scratch.path() / "few/frames/0060.png");
  const Image8 many = read_png8(scratch.path() / "many/frames/0060.png");
  return {at_most("demo's frame 60 against 1024 samples: mean FLIP", flip(many, few).mean, 0.08, "")};
}

// seconds that rendering some frames of a run took, set-up and clip aside
double render_seconds(const std::filesystem::path& run, const std::string& frames, std::vector<std::string> settings) {
  const ScratchFolder scratch;
  std::vector<std::string> command{program(), "render", run, "--frames", frames, "-o", scratch.path() / "pictures",
                                   "--quiet"};
  for (std::string& setting : settings) command.insert(command.end(), {"--set", std::move(setting)});
  measure_command(command);
  const auto record = read_run_record(scratch.path() / "pictures/run.json");
  if (!record) throw std::runtime_error("the pictures have no record");
  return record->render_seconds;
}

// in turns, so that both meet the same machine
BenchRows blur() {
  const ScratchFolder scratch;
  const std::filesystem::path run = scratch.path() / "demo";
  measure_command({program(), "simulate", "figure", "-o", run, "--quiet"});
  double sharp = 0, blurred = 0;
  for (int turn = 0; turn < 3; ++turn) {
    sharp += render_seconds(run, "15-135x20", {});
    blurred += render_seconds(run, "15-135x20", {"render.shutter=0.5"});
  }
  return {at_most("motion blur's cost in the demo, shutter 0.5, 7 frames", blurred / sharp, 1.3, "x",
                  fmt::format("{:.2f} s a frame against {:.2f} s", blurred / 21, sharp / 21))};
}

// what more samples cost: without set-up, hierarchy and files
BenchRows paths() {
  const ScratchFolder scratch;
  const std::filesystem::path run = scratch.path() / "demo";
  measure_command({program(), "simulate", "figure", "-o", run, "--frames", "1-60", "--quiet"});
  const auto seconds = [&](int samples) {
    return render_seconds(run, "60", {"render.denoise=false", fmt::format("render.samples={}", samples)});
  };
  double least = 1e9;
  for (int turn = 0; turn < 3; ++turn) least = std::min(least, seconds(80) - seconds(16));
  return {{"demo's frame 60: time of a path, all cores", fmt::format("{:.0f} ns", least / (64.0 * 640 * 360) * 1e9), "",
           true}};
}

// the noise that is asked for, and what it saves against the same number of samples everywhere
BenchRows adaptive() {
  const ScratchFolder scratch;
  const std::filesystem::path run = scratch.path() / "demo";
  measure_command({program(), "simulate", "figure", "-o", run, "--frames", "1-60", "--quiet"});
  const double all = render_seconds(run, "60", {"render.samples=256"});
  const double enough = render_seconds(run, "60", {"render.samples=256", "render.noise=0.02"});
  return {{"demo's frame 60, at most 256 samples: seconds to a noise of 0.02",
           fmt::format("{:.2f} s of {:.2f} s", enough, all), "", true}};
}

// frames that follow each other, as a user looks at them
BenchRows previews() {
  const ScratchFolder scratch;
  const std::filesystem::path run = scratch.path() / "demo";
  measure_command({program(), "simulate", "figure", "-o", run, "--frames", "1-60", "--quiet"});
  const double small = render_seconds(run, "21-60", {"render.preview=true"}) / 40;
  const double large = render_seconds(run, "21-60", {"render.preview=true", "render.size=[1280, 720]"}) / 40;
  return {at_most("preview frame of the figure, 640x360", small, 0.1, "s"),
          at_most("preview frame of the figure, 1280x720", large, 0.4, "s")};
}

BenchRows armadillo_memory() {
  const ScratchFolder scratch;
  const Measurement outcome = measure_command(
      {program(), "run", "armadillo", "--set", "body.armadillo.mesh=" + model_path("armadillo.obj"), "--size",
       "1280x720", "--samples", "4", "--frames", "1-4", "-o", scratch.path() / "clip", "--quiet"});
  return {at_most("armadillo clip at 1280x720: peak memory", gibibytes(outcome.peak_bytes), 1, "GiB")};
}

BenchRows large_beam() {
  const ScratchFolder scratch;
  const Measurement outcome =
      measure_command({program(), "simulate", "beam", "--set", "body.beam.cage.cells=[226,21,21]", "--set",
                       "body.beam.limit.kind=none", "--frames", "1-2", "-o", scratch.path() / "beam", "--quiet"});
  return {at_most("beam, 99,666 hexes, no limits: peak memory", gibibytes(outcome.peak_bytes), 8, "GiB",
                  fmt::format("one step and set-up in {:.0f} s", outcome.seconds))};
}

BenchRows ten_thousand() {
  const ScratchFolder scratch;
  const Measurement outcome = measure_command({program(), "simulate", "figure", "--set", "body.figure.cage.cells=10000",
                                               "--frames", "1-3", "-o", scratch.path() / "figure", "--quiet"});
  return {at_most("figure, 10 k hexes: peak memory", gibibytes(outcome.peak_bytes), 1, "GiB")};
}

// one second of clip with a cage of a million hexes, its landing in it; every step must converge
BenchRows million() {
  const ScratchFolder scratch;
  const std::filesystem::path folder = scratch.path() / "figure";
  const Measurement outcome =
      measure_command({program(), "simulate", "figure", "--set", "body.figure.cage.cells=1000000", "--frames", "1-60",
                       "--strict", "-o", folder, "--quiet"});
  const StepsFound steps = read_steps(folder / "steps.csv", steps_header({}));
  const auto most = [&](const char* column) {
    const std::vector<double>& values = steps.columns.at(column);
    return *std::max_element(values.begin(), values.end());
  };
  const std::string what = "figure, 1 M hexes, one second of clip";
  return {at_most(what, outcome.seconds / 60, 30, "min",
                  fmt::format("{} steps, the longest {:.0f} s, {:.0f} retries at most", steps.rows,
                              most("wall_ms") / 1e3, most("retries"))),
          at_most(what + ": peak memory", gibibytes(outcome.peak_bytes), 4, "GiB"),
          at_most(what + ": max U/U_max", most("max_energy_ratio"), 1.001, "")};
}

// the heap's bodies again and again, in towers side by side
Scene crowd_scene(int count) {
  constexpr double between_towers = 3;  // [m]
  Scene scene = load_scene("heap");
  const std::vector<BodyDescription> heap = scene.bodies;
  scene.bodies.clear();
  for (int i = 0; i < count; ++i) {
    const int tower = i / int(heap.size());
    BodyDescription body = heap[std::size_t(i) % heap.size()];
    body.name = fmt::format("b{:03}", i);
    *body.position += between_towers * Vector3d(tower % 3 - 1, 0, tower / 3 - 1);
    scene.bodies.push_back(body);
  }
  return scene;
}

struct CrowdRun {
  Measurement whole, set_up;
  double step_ms = 0;  // mean
  long long hexes = 0, steps = 0, not_converged = 0;
};
CrowdRun run_crowd(int count) {
  const ScratchFolder scratch;
  write_file(scratch.path() / "crowd.toml", resolved_toml(crowd_scene(count)));
  const auto simulate = [&](const std::string& run, const std::string& frames) {
    return measure_command({program(), "simulate", scratch.path() / "crowd.toml", "-o", scratch.path() / run, "--set",
                            "clip.frames=" + frames, "--quiet"});
  };
  CrowdRun crowd;
  crowd.set_up = simulate("start", "1");
  crowd.whole = simulate("run", "181");
  const StepsFound steps = read_steps(scratch.path() / "run/steps.csv", steps_header({}));
  crowd.steps = steps.rows;
  crowd.not_converged = std::count(steps.converged.begin(), steps.converged.end(), false);
  crowd.hexes = (long long)steps.columns.at("hexes").front();
  for (const double ms : steps.columns.at("wall_ms")) crowd.step_ms += ms / double(steps.rows);
  return crowd;
}

BenchRows hundred_figures() {
  const CrowdRun twelve = run_crowd(12), hundred = run_crowd(100);
  const std::string what = fmt::format("100 figures, {} hexes", hundred.hexes);
  const auto per_hex = [](const CrowdRun& run) { return 1e3 * run.step_ms / double(run.hexes); };
  return {at_most(what + ": 3 s at 60 frames/s", hundred.whole.seconds / 60, 10, "min",
                  fmt::format("{} of {} steps not converged", hundred.not_converged, hundred.steps)),
          at_most(what + ": peak memory", gibibytes(hundred.whole.peak_bytes), 4, "GiB"),
          at_most(what + ": set-up", hundred.set_up.seconds, 60, "s"),
          at_most("cost per hex and step, 100 figures over 12", per_hex(hundred) / per_hex(twelve), 2, "times",
                  fmt::format("{:.2f} us, {:.2f} us", per_hex(hundred), per_hex(twelve)))};
}

std::vector<std::string> reproduce(const std::filesystem::path& report) {
  std::vector<std::string> command{program(), "reproduce", "--quiet", "-o", report};
  if (!model_path("").empty()) {
    command.push_back("--set");
    command.push_back("body.armadillo.mesh=" + model_path("armadillo.obj"));
  }
  return command;
}

BenchRows tuning() {
  const ScratchFolder scratch;
  const std::filesystem::path folder = scratch.path() / "tune";
  const Measurement outcome = measure_command({program(), "tune", "figure", "--vary",
                                               "body.figure.limit.stretch=2.5%,5%,7.5%,10%,15%,20%,30%,40%", "--set",
                                               "clip.frames=120", "-o", folder, "--quiet"});
  const double megabytes = double(std::filesystem::file_size(folder / "tune.html")) / 1e6;
  return {at_most("umax tune: 8 variants of figure, 120 frames, 320x180", outcome.seconds, 70, "s",
                  fmt::format("{:.0f} s of processors", outcome.cpu_seconds)),
          at_most("its page", megabytes, 25, "MB")};
}

BenchRows quick_report() {
  const ScratchFolder scratch;
  std::vector<std::string> command = reproduce(scratch.path() / "report");
  command.push_back("--quick");
  return {at_most("umax reproduce --quick: the paper's experiments", measure_command(command).seconds / 60, 5, "min")};
}

// one experiment after the other into one report, as a user might
BenchRows whole_report() {
  const ScratchFolder scratch;
  BenchRows rows;
  double sum = 0, longest = 0;
  std::string slowest;
  for (const Experiment& experiment : experiments()) {
    std::vector<std::string> command = reproduce(scratch.path() / "report");
    command.insert(command.begin() + 2, experiment.name);
    if (sum > 0) command.push_back("--resume");
    const double minutes = measure_command(command).seconds / 60;
    sum += minutes;
    if (minutes > longest) slowest = experiment.name;
    longest = std::max(longest, minutes);
  }
  return {at_most("umax reproduce NAME: the longest", longest, 10, "min", slowest),
          at_most("umax reproduce, all names", sum, 40, "min")};
}

// a build from nothing; the source folder is told by tools/bench
BenchRows clean_build() {
  const char* source = std::getenv("UMAX_SOURCE");
  if (!source) throw std::runtime_error("run this one through tools/bench");
  const ScratchFolder scratch;
  measure_command({"cmake", "-S", source, "-B", scratch.path(), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                   "-DUMAX_ARCH=x86-64-v3"});
  const Measurement outcome = measure_command({"cmake", "--build", scratch.path(), "--parallel", "2"});
  return {at_most("clean build of everything, 2 jobs", outcome.seconds / 60, 6, "min")};
}

}  // namespace

std::vector<Benchmark> program_benchmarks() {
  return {
      {"memory", false, true, armadillo_memory},
      {"10k", false, false, ten_thousand},
      {"100k", false, false, large_beam},
      {"figure-1m", true, false, million},
      {"figures-100", true, false, hundred_figures},
      {"demo", false, false, demo},
      {"noise", true, false, noise},
      {"paths", true, false, paths},
      {"blur", true, false, blur},
      {"adaptive", true, false, adaptive},
      {"preview", true, false, previews},
      {"tune", false, false, tuning},
      {"reproduce-quick", false, false, quick_report},
      {"reproduce", true, false, whole_report},
      {"build", true, false, clean_build},
  };
}

}  // namespace umax
