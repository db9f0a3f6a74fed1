#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "core/files/write_file.h"
#include "tools/cli/verbs.h"
#include "tools/reproduce/experiments.h"
#include "tools/run/job.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"
#include "tools/system/version.h"

namespace umax {
namespace {

/// The experiments that the command line names, or all. Throws Error (usage) for a name that there is not.
std::vector<std::string> wanted_names(const Options& options) {
  std::vector<std::string> known;
  for (const Experiment& experiment : experiments()) known.emplace_back(experiment.name);
  for (const std::string& name : options.inputs)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(Fault::usage, {.where = "umax reproduce " + name,
                                 .what = "there is no such experiment",
                                 .remedy = fmt::format("did you mean {}? There are {}", nearest_word(name, known),
                                                       fmt::join(known, ", "))});
  return options.inputs.empty() ? known : options.inputs;
}

std::string made_by(const Options& options) {
  return fmt::format("Made by umax {} on {}{}.", version_text(), host_description(),
                     options.quick ? " with --quick: small pictures of few samples, times measured once" : "");
}

/// Runs the experiments in the paper's order; those that the folder's page has already are read again, so that one page
/// shows them all.
Report run_experiments(const std::vector<std::string>& wanted, const Options& options, Workbench& bench,
                       Progress& progress) {
  Report report{.made_by = made_by(options), .sections = {}};
  std::vector<std::string> names = wanted;
  const std::vector<std::string>& before = bench.folder().record().sections;
  names.insert(names.end(), before.begin(), before.end());
  for (const Experiment& experiment : experiments()) {
    if (std::find(names.begin(), names.end(), experiment.name) == names.end()) continue;
    progress.note(fmt::format("== {}", experiment.name));
    report.sections.push_back(experiment.run(bench));
    // after each: a run of an hour shows what it has
    bench.folder().add_section(experiment.name);
    write_file(bench.folder().numbers(), report_csv(report));
    write_file(bench.folder().page(), report_page(report));
  }
  return report;
}

}  // namespace

int verb_reproduce(const Options& options) {
  const std::vector<std::string> names = wanted_names(options), armadillo = armadillo_settings_of(options);
  const ThreadLimit threads(options.threads);
  Progress progress(stdout, options.progress, options.quiet);
  ReportFolder folder(output_folder(options, "report"), options.existing_folder());
  Workbench bench(folder, options, armadillo, progress, threads.count());
  const SignalWatch watch;
  try {
    run_experiments(names, options, bench, progress);
  } catch (const Interrupted& interrupted) {
    progress.note(fmt::format("stopped by signal {}; what is finished is kept, --resume goes on", interrupted.signal));
    return 128 + interrupted.signal;
  }
  progress.note(fmt::format("report: {}", folder.page().string()));
  return 0;
}

}  // namespace umax
