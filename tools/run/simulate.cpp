#include "tools/run/simulate.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <optional>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "tools/run/frame_list.h"
#include "tools/run/steps_csv.h"
#include "tools/setup/stepping.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace umax {
namespace {

/// Where a run goes on.
struct Start {
  int frame = 0;  // its state is there; 0: none is
  State state;
  std::vector<bool> converged;  // of the steps that led to it
};

/// Reads a state of this run; false, and a warning, when it is damaged. A state of another scene is not ours to
/// replace.
bool load_whole_state(const Simulation& simulation, const std::filesystem::path& path, State& state,
                      Progress& progress) {
  const std::string bytes = read_file(path);
  Digest made_with;
  try {
    state = decode_state(bytes, path.string(), made_with);
  } catch (const Error& error) {
    if (error.fault() != Fault::bad_data) throw;
    progress.warning(
        fmt::format("{} {}; it is computed again from the state before", path.string(), error.text().what));
    return false;
  }
  require_state_of(simulation.model, simulation.digest, path, state, made_with);
  return true;
}

/// The newest state that is whole and whose steps stand in steps.csv.
Start find_start(const Simulation& simulation, const RunFolder& folder, Progress& progress) {
  Start start;
  const StepsFound steps = read_steps(folder.steps(), steps_header(probe_names(simulation.scene)));
  const long long substeps = simulation.scene.clip.substeps;
  const int found = count_states(folder.path());
  const int with_steps = int(std::min<long long>(found, steps.rows / substeps + 1));
  if (with_steps < found)
    progress.warning(
        fmt::format("{} ends before the last state; going on from frame {}", folder.steps().string(), with_steps));

  for (start.frame = with_steps; start.frame > 0; --start.frame)
    if (load_whole_state(simulation, folder.state(start.frame), start.state, progress)) break;
  start.converged.assign(steps.converged.begin(),
                         steps.converged.begin() + std::ptrdiff_t(std::max(0, start.frame - 1) * substeps));
  return start;
}

/// Advances by one time step and measures it.
StepRow timed_step(Stepping& stepping, int frame, State& state) {
  const Simulation& simulation = *stepping.simulation;
  const auto begin = std::chrono::steady_clock::now();
  StepRow row;
  row.report = advance(stepping, recorded_pulls(simulation, state), state);
  row.wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  row.step = state.step;
  row.frame = frame;
  row.time = state.time;
  row.hexes = simulation.model.num_hexes();
  row.probes = probe_positions(simulation, state.positions);
  return row;
}

void refuse_unconverged(const StepRow& row) {
  throw Error(Fault::try_again, {.where = fmt::format("step {} (frame {}, {:.4g} s)", row.step, row.frame, row.time),
                                 .what = "did not converge",
                                 .value = status_name(row.report.status),
                                 .remedy = "raise clip.substeps or solver.tolerance, or leave --strict out"});
}

void require_finite(const State& state, const StepRow& row) {
  if (state.positions.allFinite() && state.velocities.allFinite()) return;
  throw Error(Fault::internal, {.where = fmt::format("step {} (frame {})", row.step, row.frame),
                                .what = "positions are no longer finite",
                                .remedy = "please report it with the scene; more clip.substeps may help"});
}

std::string describe(const StepReport& report) {
  std::string text = fmt::format("{} limits, {} contacts", report.limits_active, report.contacts);
  if (report.status != StepStatus::converged) text += fmt::format(", {}", status_name(report.status));
  return text;
}

/// Thrown in the middle of a step.
struct Interrupted {};

Stepping watched_stepping(const Simulation& simulation, bool verbose, Progress& progress) {
  Stepping stepping = begin_stepping(simulation);
  stepping.options.on_iteration = [&progress, verbose](const IterationReport& at) {
    if (stop_signal() != 0) throw Interrupted{};
    progress.within_frame(fmt::format("iteration {}, kkt_residual {:.1e}", at.iteration, at.kkt_residual));
    if (verbose)
      progress.note(fmt::format(
          "  iteration {}: max_energy_ratio {:.6g}, max_penetration {:.2e} m, largest move {:.2e} cells, kkt_residual "
          "{:.2e}, {} limits, {} contacts",
          at.iteration, at.max_energy_ratio, at.max_penetration, at.largest_move, at.kkt_residual, at.limits_active,
          at.contacts));
  };
  return stepping;
}

/// The steps to a frame; none if a signal has come before its end.
std::vector<StepRow> steps_to_frame(Stepping& stepping, bool strict, int frame, State& state) {
  std::vector<StepRow> rows;
  try {
    for (int i = 0; i < stepping.simulation->scene.clip.substeps; ++i) {
      if (stop_signal() != 0) return {};
      rows.push_back(timed_step(stepping, frame, state));
      require_finite(state, rows.back());
      if (strict && rows.back().report.status != StepStatus::converged) refuse_unconverged(rows.back());
    }
  } catch (const Interrupted&) {
    return {};
  }
  return rows;
}

/// Leads the state from rest to the first frame. False: a signal has come.
bool to_first_frame(Stepping& stepping, Progress& progress, State& state) {
  const auto stop_if_asked = [] {
    if (stop_signal() != 0) throw Interrupted{};
  };
  try {
    const Preroll done = preroll(stepping, stop_if_asked, state);
    if (done.not_converged > 0)
      progress.warning(fmt::format("{} of {} steps of clip.preroll did not converge", done.not_converged, done.steps));
  } catch (const Interrupted&) {
    return false;
  }
  return true;
}

void warn_of_unconverged(const SimulateResult& result, long long before, Progress& progress) {
  if (result.steps_not_converged > before)
    progress.warning(
        fmt::format("{} of {} steps did not converge (see status in steps.csv); where it is iteration_limit, more "
                    "clip.substeps or a looser solver.tolerance help, where it is infeasible, a higher limit or a "
                    "gentler obstacle",
                    result.steps_not_converged, result.steps));
}

}  // namespace

SimulateResult simulate(const Simulation& simulation, const RunFolder& folder, const SimulateOptions& options,
                        Progress& progress) {
  use_standard_floating_point();
  Start start = find_start(simulation, folder, progress);
  SimulateResult result{.frames = start.frame, .steps = start.state.step, .steps_not_converged = 0, .signal = 0};
  for (const bool converged : start.converged) result.steps_not_converged += !converged;
  const long long unconverged_before = result.steps_not_converged;
  if (start.frame >= options.last_frame) return result;

  create_folder(folder.states());
  progress.begin("simulate", options.last_frame, start.frame);
  StepsFile steps(folder.steps(), steps_header(probe_names(simulation.scene)), start.frame > 0 ? start.state.step : 0);
  State state = std::move(start.state);
  Stepping stepping = watched_stepping(simulation, options.verbose, progress);
  if (start.frame == 0) {
    state = rest_state(simulation.model);
    if (!to_first_frame(stepping, progress, state)) {
      result.signal = stop_signal();
      return result;
    }
    write_state(folder.state(1), state, simulation.digest);
    result.frames = 1;
    progress.frame_done(1);
  }

  for (int frame = result.frames + 1; frame <= options.last_frame; ++frame) {
    const std::vector<StepRow> rows = steps_to_frame(stepping, options.strict, frame, state);
    if (rows.empty()) {
      result.signal = stop_signal();
      break;
    }

    folder.require_hold();
    // rows first: a state without its rows would not be found again
    steps.append(rows);
    write_state(folder.state(frame), state, simulation.digest);
    result.frames = frame;
    result.steps = state.step;
    for (const StepRow& row : rows) result.steps_not_converged += row.report.status != StepStatus::converged;
    progress.frame_done(frame, describe(rows.back().report));
  }
  progress.end();
  warn_of_unconverged(result, unconverged_before, progress);
  return result;
}

}  // namespace umax
