#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "core/files/write_file.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"
#include "tools/reproduce/experiments.h"
#include "tools/run/run_record.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"
#include "tools/system/version.h"

namespace umax {
namespace {

std::vector<std::string> known_names() {
  std::vector<std::string> known;
  for (const Experiment& experiment : experiments()) known.emplace_back(experiment.name);
  return known;
}

/// The experiments that the command line names, or all. Throws Error (usage) for a name that there is not.
std::vector<std::string> wanted_names(const Options& options) {
  const std::vector<std::string> known = known_names();
  for (const std::string& name : options.inputs)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(Fault::usage, {.where = "umax reproduce " + name,
                                 .what = "there is no such experiment",
                                 .remedy = fmt::format("did you mean {}? There are {}", nearest_word(name, known),
                                                       fmt::join(known, ", "))});
  return options.inputs.empty() ? known : options.inputs;
}

std::string made_by(bool quick) {
  return fmt::format("Made by umax {} on {}{}.", version_text(), host_description(),
                     quick ? " with --quick: small pictures of few samples, times measured once" : "");
}

/// Runs the experiments in the paper's order; those that the folder's page has already are read again, so that one page
/// shows them all.
Report run_experiments(const std::vector<std::string>& wanted, Workbench& bench, Progress& progress) {
  Report report{.made_by = made_by(bench.quick()), .sections = {}};
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

int reproduce(const Options& options) {
  const std::vector<std::string> names = wanted_names(options), armadillo = armadillo_settings_of(options.settings);
  const ThreadLimit threads(options.threads);
  Progress progress(stdout, progress_mode(options), options.quiet);
  ReportFolder folder(output_folder(options, "report"), existing_folder(options));
  const ReportOptions making{.quick = options.quick,
                             .samples = options.samples,
                             .armadillo = armadillo,
                             .run = run_options(options, threads.count())};
  Workbench bench(folder, making, progress);
  const SignalWatch watch;
  try {
    run_experiments(names, bench, progress);
  } catch (const Interrupted& interrupted) {
    progress.note(stop_note(interrupted.signal));
    return exit_code_after(interrupted.signal);
  }
  progress.note(fmt::format("report: {}", folder.page().string()));
  return 0;
}

}  // namespace

Verb reproduce_verb() {
  return {
      .name = "reproduce",
      .usage = "[NAME...]",
      .summary = "the paper's figures and tables",
      .details =
          "Runs the experiments of the paper that the program implements and writes DIR/index.html, a page that shows "
          "what came out beside what the paper prints, DIR/report.csv with all numbers, and the pictures. NAME is one "
          "of figure1, figure3, figure4, figure5, figure6, performance, convergence, corrections; without a name, all "
          "of them. With --resume a report that was stopped goes on, and further experiments join its page.",
      .examples = {"umax reproduce figure3 --quick", "umax reproduce --set body.armadillo.mesh=armadillo.obj"},
      .arguments = {.words = known_names},
      .options = {"--output", "--set", "--resume", "--overwrite", "--deadline", "--quick", "--samples", "--threads",
                  "--isa", "--memory", "--progress", "--quiet", "--verbose"},
      .run = reproduce};
}

}  // namespace umax
