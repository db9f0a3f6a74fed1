#include "tools/aim/aiming.h"

#include <fmt/format.h>

#include "core/files/write_file.h"
#include "tools/aim/aim_page.h"
#include "tools/aim/aim_pictures.h"
#include "tools/aim/verdict.h"
#include "tools/system/signals.h"
#include "tools/trials/snippet.h"
#include "tools/trials/trial_names.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

/// Lines that give a scene the run's values, and what was set for all runs but how it is drawn.
std::string lines_of(const AimPlan& plan, const AimRun& run) {
  std::vector<Override> settings = found_settings(plan, run);
  for (const Override& setting : plan.request.settings)
    if (!setting.key.starts_with("render.") && !setting.key.starts_with("camera.")) settings.push_back(setting);
  return scene_snippet(run.scene, settings);
}

std::string command_of(const AimPlan& plan, const AimRun& run) {
  std::string command = "umax run " + shell_word(plan.request.scene);
  std::vector<Override> settings = plan.request.settings;
  const std::vector<Override> found = found_settings(plan, run);
  settings.insert(settings.end(), found.begin(), found.end());
  for (const Override& setting : settings) command += " --set " + shell_word(setting.key + "=" + setting.value);
  return command + " -o " + shell_word(plan.scene.name + "-aimed");
}

/// Everything that shows the search. False when a signal stopped it.
bool write_report(const AimPlan& plan, const AimFolder& folder, const AimRuns& runs, const AimRun& best,
                  const AimReport& report, int threads, Progress& progress) {
  std::vector<fs::path> files{folder.lines()};
  write_file(folder.lines(), report.lines);
  for (std::size_t k = 0; k < plan.keys.size(); ++k) {
    files.push_back(folder.plot(plan.keys[k].short_key));
    write_file(files.back(), draw_aim_plot(plan, k, runs, best));
  }
  if (!write_before_after(plan, folder, runs, best, threads)) return false;
  write_file(folder.record(), aim_record(plan, runs, best, report));
  write_file(folder.page(), aim_page_html(plan, folder, runs, best, report));
  files.push_back(folder.strip());
  files.push_back(folder.page());
  for (const fs::path& file : files) progress.note(file.string());
  return true;
}

int stopped(Progress& progress) {
  progress.note(stop_note(stop_signal()));
  return exit_code_after(stop_signal());
}

}  // namespace

int do_aim(const AimPlan& plan, const AimFolder& folder, const TrialOptions& options, Progress& progress) {
  folder.remove_pages();
  AimRuns runs(plan, folder, options, progress);
  const AimProblem problem{.num_keys = int(plan.keys.size()),
                           .num_wants = int(plan.wants.size()),
                           .start = runs.start(),
                           .most_tries = plan.most_runs - (runs.start() ? 0 : 1)};
  const AimResult result = solve_aim(problem, [&](const std::vector<VectorXd>& places) { return runs.make(places); });
  if (stop_signal() != 0) return stopped(progress);
  if (result.end == AimEnd::stopped) return runs.exit_code();
  const AimRun& best = runs.at(result.tries[result.best].place);
  const AimReport report{.reached = result.end == AimEnd::reached,
                         .verdict = verdict_text(plan, result, runs),
                         .lines = lines_of(plan, best),
                         .command = command_of(plan, best)};
  progress.note(report.verdict);
  progress.note(report.lines);
  if (!write_report(plan, folder, runs, best, report, options.threads, progress)) return stopped(progress);
  return report.reached ? 0 : exit_code_not_reached;
}

}  // namespace umax
