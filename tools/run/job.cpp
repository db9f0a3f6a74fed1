#include "tools/run/job.h"
#include "tools/setup/body_contact.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/files/sha256.h"
#include "core/files/write_file.h"
#include "scenes/resolved_scene.h"
#include "tools/exchange/export_list.h"
#include "tools/pictures/exposure.h"
#include "tools/run/clip.h"
#include "tools/run/export_run.h"
#include "tools/run/frame_list.h"
#include "tools/run/job_estimate.h"
#include "tools/run/run_record.h"
#include "tools/run/simulate.h"
#include "tools/run/step_plots.h"
#include "tools/setup/limit_report.h"
#include "tools/system/exit_code.h"
#include "tools/system/machine_memory.h"
#include "tools/system/seconds_since.h"
#include "tools/system/signals.h"
#include "tools/system/version.h"

namespace umax {
namespace {

/// run.json while the job runs: written at the start, after every stage and at the end.
class RecordKeeper {
 public:
  RecordKeeper(const RunFolder& folder, const RunOptions& options, const std::string& scene_text,
               const Simulation& simulation)
      : path_(folder.record()), record_(read_run_record(folder.record()).value_or(RunRecord{})) {
    record_.version = version_text();
    record_.verb = options.verb;
    record_.scene = simulation.scene.name;
    record_.scene_sha256 = sha256_hex(scene_text);
    record_.model_sha256 = simulation.digest;
    record_.host = host_description();
    record_.threads = options.threads;
    record_.exit_status.reset();
    write();
  }
  RunRecord& record() { return record_; }
  void write() {
    record_.peak_memory = std::max(record_.peak_memory, peak_memory());
    write_run_record(path_, record_);
  }
  int finish(int exit_status) {
    record_.exit_status = exit_status;
    write();
    return exit_status;
  }
  void finish_after_error(int exit_status) {
    try {
      finish(exit_status);
    } catch (const Error&) {  // NOLINT(bugprone-empty-catch): as the line below says
      // the disk that refuses this refused something before: that is what the user is told
    }
  }

 private:
  std::filesystem::path path_;
  RunRecord record_;
};

/// Time steps up to a frame that the folder does not have yet.
long long steps_left(const Job& job, int last_state) {
  if (!job.simulate) return 0;
  const int found = job.existing == ExistingFolder::keep ? count_states(job.folder) : 0;
  return std::max(0LL, (last_state - std::max(1LL, (long long)(found))) * job.scene.clip.substeps);
}

/// The last state that these frames need: that of a neighbour, where they are blurred or have motion vectors.
int last_state_of(const Job& job, const std::vector<int>& frames) {
  return states_for(job.scene.render, frames.back(), job.scene.clip.frames).last;
}

/// Refuses what does not fit into the memory, and says what a large job will take.
void tell_cost(const Simulation& simulation, long long steps, long long memory, Progress& progress) {
  const JobSize size = size_of(simulation);
  require_memory(size, simulation.scene, double(memory));
  if (const std::string text = announce(size, steps); !text.empty()) progress.note(text);
}

/// What the folder is needed for, checked as long as nothing has been written.
void check_before_start(const Job& job, const std::vector<int>& frames) {
  check_run_folder(job.folder, job.existing);
  for (const ExportOptions& options : job.exports) {
    check_export(options, frames);
    if (job.existing == ExistingFolder::keep)
      refuse_misfits(exports_path(job.folder), options, "remove it, or export with umax export and -o another folder");
  }
  if (!job.pictures || !job.clip) return;
  require_even_size(job.scene.render.width, job.scene.render.height);
  require_clip_encoder();
}

/// Simulates and plots what steps.csv then holds, also when --strict ends the run.
SimulateResult simulate_and_plot(const Simulation& simulation, const RunFolder& folder, const SimulateOptions& options,
                                 Progress& progress) {
  try {
    const SimulateResult result = simulate(simulation, folder, options, progress);
    write_step_plots(folder, simulation.scene);
    return result;
  } catch (const Error& error) {
    if (error.fault() == Fault::try_again) write_step_plots(folder, simulation.scene);
    throw;
  }
}

/// A job whose folder is ours.
struct JobInHand {
  const Job& job;
  const RunOptions& options;
  const Simulation& simulation;
  const std::vector<int>& frames;
  const RunFolder& folder;
  RecordKeeper& keeper;
  Progress& progress;
};

/// Simulates; returns the signal that stopped it, or 0.
int simulate_stage(const JobInHand& hand) {
  const auto start = std::chrono::steady_clock::now();
  const SimulateOptions options{.last_frame = last_state_of(hand.job, hand.frames),
                                .strict = hand.options.strict,
                                .verbose = hand.options.verbose};
  const SimulateResult result = simulate_and_plot(hand.simulation, hand.folder, options, hand.progress);
  RunRecord& record = hand.keeper.record();
  record.simulate_seconds += seconds_since(start);
  record.frames = result.frames;
  record.steps = result.steps;
  record.steps_not_converged = result.steps_not_converged;
  hand.keeper.write();
  return result.signal;
}

/// Exports; returns the signal that stopped it, or 0.
int export_stage(const JobInHand& hand) {
  for (const ExportOptions& options : hand.job.exports) {
    const ExportResult result =
        export_run(hand.simulation, hand.folder.path(), hand.frames, hand.folder.exports(), options, hand.progress);
    if (result.signal != 0) return result.signal;
  }
  const std::string short_ones = caches_that_end_before(hand.folder.exports(), hand.frames.back());
  if (!short_ones.empty())
    hand.progress.warning(fmt::format("{}: {} end before frame {}, as they were exported before: export them again",
                                      hand.folder.exports().string(), short_ones, hand.frames.back()));
  return 0;
}

/// A clip that was longer or shorter when its pictures were made cut off their blur and motion elsewhere: those go.
void remove_pictures_of_other_length(const JobInHand& hand, int frames_then) {
  const Scene& scene = hand.job.scene;
  if (frames_then == 0) return;
  const auto window = [&](int frame, int last) {
    return std::pair(exposure_of(scene.render, frame, last), states_for(scene.render, frame, last));
  };
  for (int frame = 1; frame <= std::max(frames_then, scene.clip.frames); ++frame)
    if (window(frame, frames_then) != window(frame, scene.clip.frames)) hand.folder.remove_picture(frame);
}

/// Renders and encodes; returns the signal that stopped it, or 0.
int picture_stage(const JobInHand& hand, const RunPictures& pictures) {
  const Scene& scene = hand.job.scene;
  RunRecord& record = hand.keeper.record();
  const bool is_stale = !record.pictures_sha256.empty() && record.pictures_sha256 != pictures.digest;
  if (is_stale) {
    hand.progress.note("the pictures that are there were made with other settings: they are made anew");
    hand.folder.remove_pictures();
  }
  if (!is_stale) remove_pictures_of_other_length(hand, record.pictures_frames);
  record.pictures_sha256 = pictures.digest;
  record.pictures_frames = scene.clip.frames;
  hand.keeper.write();

  auto start = std::chrono::steady_clock::now();
  const RenderResult result =
      render_pictures(pictures.list, scene.render, hand.options.threads, hand.folder, hand.progress);
  record.render_seconds += seconds_since(start);
  hand.keeper.write();
  if (result.signal != 0) return result.signal;
  if (!hand.job.clip) return 0;

  start = std::chrono::steady_clock::now();
  encode_pictures(hand.folder, pictures.list.frames, scene, hand.progress);
  record.encode_seconds += seconds_since(start);
  return 0;
}

/// Everything after the checks: `ready` are the pictures when they do not wait for the simulation. Returns the exit
/// code.
int do_stages(const JobInHand& hand, std::optional<RunPictures> ready) {
  const SignalWatch watch;
  int signal = 0;
  if (hand.job.simulate) signal = simulate_stage(hand);
  if (signal == 0) signal = export_stage(hand);
  if (hand.job.pictures && signal == 0) {
    const RunPictures pictures =
        ready ? std::move(*ready) : pictures_of_run(hand.simulation, hand.folder.path(), hand.frames);
    signal = picture_stage(hand, pictures);
  }
  if (signal != 0)
    hand.progress.note(fmt::format("stopped by signal {}; what is finished is kept, --resume goes on", signal));
  return signal == 0 ? 0 : 128 + signal;
}

/// States of another scene are not to be mixed with this one's.
void require_same_run(const RunFolder& folder, const Simulation& simulation) {
  const auto record = read_run_record(folder.record());
  if (!record || record->model_sha256 == simulation.digest || count_states(folder.path()) == 0) return;
  throw Error(Fault::bad_data, {.where = folder.path().string(),
                                .what = "holds the states of another scene, mesh or solver setting",
                                .remedy = "choose another folder with -o, or replace it with --overwrite"});
}

/// Keeps the exit code in run.json; a full disk before the first output means that it cannot be created, later that a
/// write failed.
[[noreturn]] void end_with(const Error& error, const RunFolder& folder, RecordKeeper& keeper) {
  const bool is_late = count_states(folder.path()) > 0 || std::filesystem::exists(folder.frames());
  const Fault fault = error.fault() == Fault::cannot_create && is_late ? Fault::io_error : error.fault();
  keeper.finish_after_error(exit_code_of(fault));
  throw Error(fault, error.text());
}

}  // namespace

int do_job(const Job& job, const RunOptions& options, Progress& progress) {
  const int last_frame = job.default_frames.value_or(job.scene.clip.frames);
  const std::vector<int> frames =
      options.frames ? parse_frame_list(*options.frames, last_frame) : all_frames(last_frame);
  check_before_start(job, frames);
  const long long steps = steps_left(job, last_state_of(job, frames));
  const long long memory = options.memory ? *options.memory : available_memory();
  // before cages are made that no memory holds, and before they are filled
  const CageWatch watch = [&](const std::vector<BodySetup>& caged) {
    if (steps > 0) require_memory(size_of(job.scene, caged), job.scene, double(memory));
    give_back_freed_memory();  // what making the cage took, before the next
  };
  watch({});

  const auto set_up_now =
      job.simulation ? job.simulation : std::make_shared<const Simulation>(set_up(job.scene, watch));
  const Simulation& simulation = *set_up_now;
  if (job.simulate && !simulation.scene.clip.allow_overlap) require_clear_start(simulation.model);
  keep_freed_memory();
  for (const std::string& warning : simulation.warnings) progress.warning(warning);
  for (const BodySetup& body : simulation.bodies) {
    progress.note(fmt::format("body {}: {} triangles, {} hexes, {} nodes", body.name, body.shape.mesh.num_triangles(),
                              body.lattice.num_hexes(), body.lattice.num_nodes()));
    for (const std::string& note : body.notes) progress.note(fmt::format("body {}: {}", body.name, note));
  }

  if (steps > 0) tell_cost(simulation, steps, memory, progress);

  std::optional<RunPictures> pictures;
  if (job.make_pictures) pictures = job.make_pictures(simulation, frames);

  const RunFolder folder(job.folder, job.existing);
  if (job.replace_pictures) folder.remove_pictures();
  const std::string scene_text = resolved_toml(job.scene, limit_comments(simulation));
  require_same_run(folder, simulation);
  write_file(folder.scene(), scene_text);
  RecordKeeper keeper(folder, options, scene_text, simulation);
  try {
    return keeper.finish(do_stages({job, options, simulation, frames, folder, keeper, progress}, std::move(pictures)));
  } catch (const Error& error) {
    end_with(error, folder, keeper);
  }
}

}  // namespace umax
