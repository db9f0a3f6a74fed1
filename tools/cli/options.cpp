#include "tools/cli/options.h"

#include "core/base/error.h"
#include "scenes/quantity.h"
#include "scenes/scene_file.h"
#include "tools/system/machine_memory.h"
#include "tools/system/threads.h"

namespace umax {

std::string single_input(const Options& options, const std::string& what) {
  if (options.inputs.size() == 1) return options.inputs.front();
  throw Error(Fault::usage,
              {.what = "umax " + options.verb + " takes one " + what, .remedy = "see umax help " + options.verb});
}

std::filesystem::path output_folder(const Options& options, const std::string& name) {
  if (!options.output) return name;
  if (options.output->empty())
    throw Error(Fault::usage, {.where = "-o", .what = "is empty", .remedy = "name a folder"});
  return *options.output;
}

ExistingFolder existing_folder(const Options& options) {
  if (options.overwrite) return ExistingFolder::overwrite;
  return options.resume ? ExistingFolder::keep : ExistingFolder::refuse;
}

void require_new_file(const std::filesystem::path& path, const Options& options) {
  std::error_code error;
  if (!options.overwrite && std::filesystem::exists(path, error))
    throw Error(
        Fault::cannot_create,
        {.where = path.string(), .what = "exists already", .remedy = "give another name with -o, or --overwrite"});
}

std::vector<Override> scene_overrides(const Options& options) {
  std::vector<Override> overrides;
  if (options.quick) {
    overrides.push_back({"render.size", "[320, 180]"});
    overrides.push_back({"render.samples", "4"});
    overrides.push_back({"render.preview", options.samples ? "false" : "true"});
  }
  if (options.allow_overlap) overrides.push_back({"clip.allow_overlap", "true"});
  for (const std::string& setting : options.settings) overrides.push_back(parse_override(setting));
  if (options.engine) overrides.push_back({"render.engine", *options.engine});
  if (options.samples) overrides.push_back({"render.samples", std::to_string(*options.samples)});
  if (options.size) overrides.push_back({"render.size", *options.size});
  if (options.seed) overrides.push_back({"render.seed", std::to_string(*options.seed)});
  return overrides;
}

ProgressMode progress_mode(const Options& options) {
  if (options.progress == "plain") return ProgressMode::plain;
  return options.progress == "json" ? ProgressMode::json : ProgressMode::automatic;
}

std::optional<long long> memory_limit(const Options& options) {
  return options.memory ? parse_memory(*options.memory) : std::nullopt;
}

std::optional<double> deadline_of(const Options& options) {
  std::string problem;
  const auto time = options.deadline ? parse_quantity(*options.deadline, units::time, problem) : std::nullopt;
  return time ? std::optional(time->value) : std::nullopt;
}

RunOptions run_options(const Options& options, int threads) {
  return {.verb = options.verb,
          .frames = options.frames,
          .threads = threads,
          .memory = memory_limit(options),
          .strict = options.strict,
          .verbose = options.verbose};
}

std::vector<ExportOptions> job_exports(const Options& options) {
  std::vector<ExportOptions> exports;
  for (const std::string& format : options.exports)
    exports.push_back({.format = parse_export_format(format), .overwrite = true});
  return exports;
}

int run_job(const Job& job, const Options& options) {
  const ThreadLimit threads(options.threads);
  Progress progress(stdout, progress_mode(options), options.quiet);
  Job wanted = job;
  wanted.clip = job.clip && !options.no_clip;
  return do_job(wanted, run_options(options, threads.count()), progress);
}

}  // namespace umax
