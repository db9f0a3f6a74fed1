#include "tools/aim/aim_runs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "scenes/scene_file.h"
#include "tools/run/steps_csv.h"
#include "tools/system/signals.h"
#include "tools/trials/trial_names.h"

namespace umax {
namespace {

/// Steps that did not converge among those that lead to the states.
int count_not_converged(const Scene& scene, const std::filesystem::path& run, int last_frame) {
  const StepsFound steps = read_steps(run / "steps.csv", steps_header(probe_names(scene)));
  const std::size_t rows = std::min(steps.converged.size(), std::size_t((last_frame - 1) * scene.clip.substeps));
  return int(std::count(steps.converged.begin(), steps.converged.begin() + std::ptrdiff_t(rows), false));
}

std::optional<VectorXd> start_of(const AimPlan& plan) {
  VectorXd start(Eigen::Index(plan.keys.size()));
  for (std::size_t k = 0; k < plan.keys.size(); ++k) {
    if (!plan.keys[k].own) return std::nullopt;
    start[Eigen::Index(k)] = *plan.keys[k].own;
  }
  return start;
}

}  // namespace

std::string reading_text(const Want& want, const Reading& reading) {
  const double miss = miss_of(want, reading);
  const double percent = 100 * std::abs(miss);
  const char* side = miss < 0 ? "less than" : "more than";
  const std::string left =
      std::abs(miss) >= 10 ? "far from" : fmt::format("{:.{}f} % {}", percent, percent < 10 ? 2 : 0, side);
  return fmt::format("{} = {} ({} wanted)", want.name, value_text(want, reading.value), left);
}

std::vector<Override> settings_of(const AimPlan& plan, const AimRun& run) {
  std::vector<Override> settings;
  for (std::size_t k = 0; k < run.values.size(); ++k) settings.push_back({plan.keys[k].key, run.values[k]});
  return settings;
}

AimRuns::AimRuns(const AimPlan& plan, const AimFolder& folder, const TrialOptions& options, Progress& progress)
    : plan_(plan), folder_(folder), progress_(progress), workers_(worker_options(options)), start_(start_of(plan)) {
  runs_.push_back({.name = "before", .label = "before", .place = start_.value_or(VectorXd()), .scene = plan.scene});
}

AimRun AimRuns::run_at(const VectorXd& place) const {
  AimRun run;
  run.place = place;
  std::vector<std::string> names, labels;
  for (std::size_t k = 0; k < plan_.keys.size(); ++k) {
    run.values.push_back(value_text(plan_.keys[k], place[Eigen::Index(k)]));
    names.push_back(folder_name(plan_.keys[k].short_key + "=" + run.values.back()));
    labels.push_back(plan_.keys[k].short_key + " " + run.values.back());
  }
  run.name = fmt::format("{}", fmt::join(names, ","));
  run.label = fmt::format("{}", fmt::join(labels, ", "));
  std::vector<Override> settings = plan_.request.settings;
  const std::vector<Override> own = settings_of(plan_, run);
  settings.insert(settings.end(), own.begin(), own.end());
  run.scene = load_scene(plan_.request.scene, settings);
  return run;
}

std::size_t AimRuns::index_of(const VectorXd& place) const {
  const auto found = std::find_if(runs_.begin(), runs_.end(), [&](const AimRun& run) {
    return run.place.size() == place.size() && run.place == place;
  });
  return std::size_t(found - runs_.begin());
}

std::optional<std::vector<VectorXd>> AimRuns::make(const std::vector<VectorXd>& places) {
  const std::size_t begin = runs_.front().readings.empty() ? 0 : runs_.size();
  for (const VectorXd& place : places)
    if (index_of(place) == runs_.size()) runs_.push_back(run_at(place));
  if (!simulate(begin)) return std::nullopt;
  read(begin);
  if (stop_signal() != 0) return std::nullopt;
  for (std::size_t i = begin; i < runs_.size(); ++i) tell(i);
  std::vector<VectorXd> misses;
  for (const VectorXd& place : places) misses.push_back(runs_[index_of(place)].miss);
  return misses;
}

/// Runs what is missing of the runs from `begin` on; false when a signal came or one failed.
bool AimRuns::simulate(std::size_t begin) {
  std::vector<WorkItem> items;
  for (std::size_t i = begin; i < runs_.size(); ++i) {
    const std::string& name = runs_[i].name;
    const auto item = missing_work({.name = name, .scene = folder_.scene(name), .run = folder_.run(name)},
                                   runs_[i].scene, {.last_frame = plan_.last_frame}, false, progress_);
    if (item) items.push_back(*item);
  }
  if (items.empty()) return true;
  for (const WorkResult& result : run_workers(items, workers_, "aim", progress_))
    if (exit_code_ == 0) exit_code_ = result.exit_code;
  if (stop_signal() != 0) exit_code_ = exit_code_after(stop_signal());
  return exit_code_ == 0;
}

void AimRuns::read(std::size_t begin) {
  std::vector<Simulation> simulations;  // of these runs
  for (std::size_t i = begin; i < runs_.size() && stop_signal() == 0; ++i)
    simulations.push_back(set_up(runs_[i].scene, library_));
  parallel_blocks(Eigen::Index(simulations.size()), 1, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index k = first; k < last && stop_signal() == 0; ++k) {
      AimRun& run = runs_[begin + std::size_t(k)];
      const Simulation& simulation = simulations[std::size_t(k)];
      const StateSource states = states_of_run(simulation, folder_.run(run.name));
      run.miss.resize(Eigen::Index(plan_.wants.size()));
      for (std::size_t w = 0; w < plan_.wants.size(); ++w) {
        run.readings.push_back(read_want(plan_.wants[w], simulation, states));
        run.miss[Eigen::Index(w)] = miss_of(plan_.wants[w], run.readings.back());
      }
      run.steps_not_converged = count_not_converged(run.scene, folder_.run(run.name), plan_.last_frame);
    }
  });
}

void AimRuns::tell(std::size_t index) const {
  const AimRun& run = runs_[index];
  std::vector<std::string> found;
  for (std::size_t w = 0; w < plan_.wants.size(); ++w) found.push_back(reading_text(plan_.wants[w], run.readings[w]));
  progress_.note(fmt::format("run {}: {}: {}", index + 1, run.label, fmt::join(found, "; ")));
  if (run.steps_not_converged > 0)
    progress_.warning(fmt::format("{}: {} steps did not converge", run.name, run.steps_not_converged));
}

}  // namespace umax
