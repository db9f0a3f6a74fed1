#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/run/export_run.h"
#include "tools/run/frame_list.h"
#include "tools/run/run_folder.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

bool z_is_up(const Options& options) {
  if (!options.up || *options.up == "y") return false;
  if (*options.up == "z") return true;
  throw Error(Fault::usage,
              {.where = "--up", .what = "of an export is y or z", .value = *options.up, .remedy = "give one of them"});
}

/// "cow,obstacle.plate"
std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t end = std::min(list.find(',', at), list.size());
    if (end == at)
      throw Error(Fault::usage, {.where = "--bodies",
                                 .what = "a name is empty",
                                 .value = '"' + list + '"',
                                 .remedy = "write names as in cow,obstacle.plate"});
    names.push_back(list.substr(at, end - at));
    at = end + 1;
  }
  return names;
}

ExportOptions export_options(const Options& options) {
  if (!options.format)
    throw Error(Fault::usage, {.what = "umax export needs a format",
                               .remedy = fmt::format("give --format {}", fmt::join(export_format_names(), "|"))});
  return {.format = parse_export_format(*options.format),
          .things = options.bodies ? names_in(*options.bodies) : std::vector<std::string>{},
          .z_up = z_is_up(options),
          .scale = options.scale.value_or(1),
          .overwrite = options.overwrite};
}

/// Those that --frames names; without it, all whose states are there.
std::vector<int> frames_of(const fs::path& run, const Scene& scene, const Options& options) {
  if (options.frames) return parse_frame_list(*options.frames, scene.clip.frames);
  const int count = std::min(count_states(run), scene.clip.frames);
  if (count == 0)
    throw Error(Fault::not_found, {.where = (run / "states").string(),
                                   .what = "there are no states",
                                   .remedy = "simulate first: umax simulate SCENE -o " + run.string()});
  return all_frames(count);
}

int export_folder(const Options& options) {
  const fs::path run = single_input(options, "folder of a run");
  const ExportOptions wanted = export_options(options);
  const Scene scene = scene_of_run(run, scene_overrides(options));
  const std::vector<int> frames = frames_of(run, scene, options);
  check_export(wanted, frames);

  const ThreadLimit threads(options.threads);
  Progress progress(stdout, progress_mode(options), options.quiet);
  const Simulation simulation = set_up(scene);
  const SignalWatch watch;
  const fs::path folder = options.output ? fs::path(*options.output) : exports_path(run);
  const ExportResult result = export_run(simulation, run, frames, folder, wanted, progress);
  return exit_code_after(result.signal);
}

}  // namespace

Verb export_verb() {
  return {
      .name = "export",
      .usage = "DIR",
      .summary = "the clip for other programs: caches, meshes, cages",
      .details =
          "Writes the deformed surfaces of a run's bodies, and its obstacles, into DIR/export: NAME.pc2 or .mdd with "
          "the "
          "mesh at rest beside it (NAME.obj); NAME.abc, .usda or .gltf, with the camera; or a folder NAME with one obj "
          "or ply file a frame. Vertices have the order of the mesh file. vtu: the cages, with energies and stresses. "
          "docs/export.md says what each format holds and how programs take it.",
      .examples = {"umax export falling --format pc2", "umax export falling --format ply --frames 1-60 --up z"},
      .arguments = {.folders = true},
      .options = {"--output", "--set", "--frames", "--overwrite", "--format", "--bodies", "--up", "--scale",
                  "--threads", "--progress", "--quiet", "--verbose"},
      .run = export_folder};
}

}  // namespace umax
