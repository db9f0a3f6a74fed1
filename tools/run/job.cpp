#include "tools/run/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "scenes/resolved_scene.h"
#include "tools/exchange/export_list.h"
#include "tools/pictures/exposure.h"
#include "tools/pictures/painter.h"
#include "tools/run/clip.h"
#include "tools/run/export_run.h"
#include "tools/run/frame_list.h"
#include "tools/run/job_estimate.h"
#include "tools/run/picture_estimate.h"
#include "tools/run/picture_work.h"
#include "tools/run/record_keeper.h"
#include "tools/run/run_log.h"
#include "tools/run/run_motion.h"
#include "tools/run/run_record.h"
#include "tools/run/simulate.h"
#include "tools/run/step_plots.h"
#include "tools/setup/body_contact.h"
#include "tools/setup/limit_report.h"
#include "tools/system/exit_code.h"
#include "tools/system/machine_memory.h"
#include "tools/system/seconds_since.h"
#include "tools/system/signals.h"
#include "tools/system/version.h"

namespace umax {
namespace {

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

/// Says what many or large pictures and their clip will take, those that are there left out.
void tell_cost(const Job& job, const Simulation& simulation, const std::vector<int>& frames, int threads,
               Progress& progress) {
  if (!job.pictures) return;
  const bool keeps = job.existing == ExistingFolder::keep && !job.replace_pictures;
  std::vector<int> open;
  std::error_code error;
  for (const int frame : frames)
    if (!keeps || !std::filesystem::exists(picture_path(job.folder, frame), error)) open.push_back(frame);
  const PictureJob cost = picture_job(simulation, open, job.clip ? int(frames.size()) : 0, threads);
  if (const std::string text = announce(cost); !text.empty()) progress.note(text);
}

/// Who simulates or removes what is there is alone; who only draws shares.
FolderUse use_of(const Job& job) {
  const bool removes = job.replace_pictures || job.existing == ExistingFolder::overwrite;
  return job.simulate || removes ? FolderUse::alone : FolderUse::shared;
}

/// What the folder is needed for, checked as long as nothing has been written.
void check_before_start(const Job& job, const std::vector<int>& frames) {
  check_run_folder(job.folder, job.existing, use_of(job));
  for (const ExportOptions& options : job.exports) {
    check_export(options, frames);
    if (job.existing == ExistingFolder::keep)
      refuse_misfits(exports_path(job.folder), options, "remove it, or export with umax export and -o another folder");
  }
  if (!job.pictures) return;
  require_engine(job.scene.render);
  if (!job.clip) return;
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

int agree(const Job& job, const RunPictures& pictures, const RunFolder& folder, Progress& progress) {
  return agree_on_pictures(folder, pictures.record, job.scene.render, job.other_pictures, progress);
}

/// A job whose folder is ours.
struct JobInHand {
  const Job& job;
  const RunOptions& options;
  const Simulation& simulation;
  const std::vector<int>& frames;
  RunFolder& folder;
  RecordKeeper& keeper;
  RunLog& log;
  Progress& progress;
};

/// Puts down what decides the last bits of the steps that this call computes, and says where others were computed otherwise.
void tell_instruction_set(const JobInHand& hand) {
  const int states = count_states(hand.folder.path());
  if (states >= last_state_of(hand.job, hand.frames)) return;
  const std::string now = instruction_set_text();
  std::string before;
  hand.keeper.change([&](RunRecord& record) {
    if (states > 1) before = record.instruction_set;
    if (!before.ends_with(now)) record.instruction_set = before.empty() ? now : before + ", then " + now;
  });
  if (before.empty() || before.ends_with(now)) return;
  hand.progress.warning(fmt::format(
      "the states that are there were computed by {}, and this call goes on by {}: not to the same last bits as "
      "in one go; --isa avx2 from the start makes machines agree",
      before, now));
}

/// Simulates; returns the signal that stopped it, or 0.
int simulate_stage(const JobInHand& hand) {
  const auto start = std::chrono::steady_clock::now();
  tell_instruction_set(hand);
  const SimulateOptions options{.last_frame = last_state_of(hand.job, hand.frames),
                                .strict = hand.options.strict,
                                .verbose = hand.options.verbose};
  const SimulateResult result = simulate_and_plot(hand.simulation, hand.folder, options, hand.progress);
  hand.log.write(fmt::format("simulated as far as frame {} in {:.1f} s", result.frames, seconds_since(start)));
  hand.keeper.change([&](RunRecord& record) {
    record.simulate_seconds += seconds_since(start);
    record.frames = result.frames;
    record.steps = result.steps;
    record.steps_not_converged = result.steps_not_converged;
  });
  if (result.signal == 0) freeze_motion(hand.simulation, hand.folder);
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

/// Renders and encodes; returns the signal that stopped it, or 0.
int picture_stage(const JobInHand& hand, const RunPictures& pictures) {
  const Scene& scene = hand.job.scene;
  for (const std::string& note : pictures.notes) hand.progress.note(note);
  auto start = std::chrono::steady_clock::now();
  const RenderResult result =
      draw_pictures(pictures.list, scene.render, hand.options.threads, hand.folder, hand.progress);
  hand.log.write(
      fmt::format("drew pictures, of which {} are there, in {:.1f} s", result.pictures, seconds_since(start)));
  hand.keeper.change([&](RunRecord& record) { record.render_seconds += seconds_since(start); });
  if (result.signal != 0 || !hand.job.clip) return result.signal;

  start = std::chrono::steady_clock::now();
  const int signal = finish_clip(hand.folder, pictures.list.frames, scene, hand.progress);
  hand.log.write(fmt::format("encoded in {:.1f} s", seconds_since(start)));
  hand.keeper.change([&](RunRecord& record) { record.encode_seconds += seconds_since(start); });
  return signal;
}

/// Puts down with which settings pictures will be drawn, unless some are there. What stands in their way is said now: it
/// is no fault of the simulation's.
void freeze_settings(const JobInHand& hand) {
  if (count_pictures(hand.folder.path()) > 0) return;
  try {
    write_picture_record(hand.folder.pictures(),
                         pictures_of_run(hand.simulation, hand.folder.path(), hand.frames).record);
  } catch (const Error& error) {
    if (error.fault() == Fault::cannot_create || error.fault() == Fault::io_error) throw;
    hand.progress.warning(std::string("pictures of this run cannot be drawn as things are: ") + error.what());
  }
}

/// Everything after the checks: `ready` are the pictures when they do not wait for the simulation. Returns the exit
/// code.
int do_stages(const JobInHand& hand, std::optional<RunPictures> ready) {
  int signal = 0;
  if (hand.job.simulate) signal = simulate_stage(hand);
  if (signal == 0) signal = export_stage(hand);
  if (!hand.job.pictures && signal == 0) freeze_settings(hand);
  if (hand.job.pictures && signal == 0) {
    const RunPictures pictures =
        ready ? std::move(*ready) : pictures_of_run(hand.simulation, hand.folder.path(), hand.frames);
    if (use_of(hand.job) == FolderUse::alone) signal = agree(hand.job, pictures, hand.folder, hand.progress);
    hand.folder.share();
    if (signal == 0) signal = picture_stage(hand, pictures);
  }
  if (signal != 0) hand.progress.note(stop_note(signal));
  return hand.keeper.finish(exit_code_after(signal), signal == 0 ? "finished" : stop_note(signal));
}

/// States of another scene are not to be mixed with this one's.
void require_same_run(const RunFolder& folder, const Simulation& simulation) {
  const auto record = read_run_record(folder.record());
  if (!record || record->model_sha256 == simulation.digest || count_states(folder.path()) == 0) return;
  throw Error(Fault::bad_data, {.where = folder.path().string(),
                                .what = "holds the states of another scene, mesh or solver setting",
                                .remedy = "choose another folder with -o, or replace it with --overwrite"});
}

void write_if_different(const std::filesystem::path& path, const std::string& text) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) || read_file(path) != text) write_file(path, text);
}

/// A full disk before the first output means that it cannot be created, later that a write failed.
Fault fault_in(const RunFolder& folder, const Error& error) {
  std::error_code unknown;
  const bool is_late = count_states(folder.path()) > 0 || std::filesystem::exists(folder.frames(), unknown) ||
                       !std::filesystem::exists(folder.path(), unknown);
  return error.fault() == Fault::cannot_create && is_late ? Fault::io_error : error.fault();
}

/// do_stages with the scene in its file, whose end is kept in run.json however it comes.
int do_recorded_stages(const JobInHand& hand, const std::string& scene_text, std::optional<RunPictures> ready) {
  try {
    write_if_different(hand.folder.scene(), scene_text);
    return do_stages(hand, std::move(ready));
  } catch (const Error& error) {
    const Error cause = explained(hand.folder, error), told(fault_in(hand.folder, cause), cause.text());
    hand.keeper.finish_after_error(exit_code_of(told.fault()), std::string("error: ") + told.what());
    throw told;
  } catch (const std::bad_alloc&) {
    hand.keeper.finish_after_error(exit_code_of(Fault::internal), "error: memory ran out");
    throw;
  } catch (...) {  // whoever listens to progress may throw what it likes
    hand.keeper.finish_after_error(exit_code_of(Fault::internal), "by an internal error, or as its caller asked");
    throw;
  }
}

}  // namespace

namespace {

/// The scene with the lights that it got when its bodies were placed.
Scene lit_scene(Scene scene, const Simulation& simulation) {
  if (!scene.wants_lights) return scene;
  scene.wants_lights = false;
  scene.lights = simulation.scene.lights;
  scene.render.sky = simulation.scene.render.sky;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) scene.obstacles[i].fade = simulation.scene.obstacles[i].fade;
  return scene;
}

std::vector<int> frames_wanted(const Job& job, const RunOptions& options) {
  const int last_frame = job.default_frames.value_or(job.scene.clip.frames);
  return options.frames ? parse_frame_list(*options.frames, last_frame) : all_frames(last_frame);
}

void tell_bodies(const Simulation& simulation, Progress& progress) {
  for (const std::string& warning : simulation.warnings) progress.warning(warning);
  for (const BodySetup& body : simulation.bodies) {
    progress.note(fmt::format("body {}: {} triangles, {} hexes, {} nodes", body.name, body.shape.mesh.num_triangles(),
                              body.lattice.num_hexes(), body.lattice.num_nodes()));
    for (const std::string& note : body.notes) progress.note(fmt::format("body {}: {}", body.name, note));
  }
}

}  // namespace

int do_job(const Job& job, const RunOptions& options, Progress& progress) {
  const std::vector<int> frames = frames_wanted(job, options);
  check_before_start(job, frames);
  RunLog log(progress);
  log.write(fmt::format("began umax {}: {}", options.verb, command_text()));
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
  tell_bodies(simulation, progress);
  if (steps > 0) tell_cost(simulation, steps, memory, progress);
  tell_cost(job, simulation, frames, options.threads, progress);

  std::optional<RunPictures> pictures;
  if (job.make_pictures) pictures = job.make_pictures(simulation, frames);

  const SignalWatch signals;
  RunFolder folder(job.folder, job.existing, use_of(job), job.clip ? draws_for_clip : draws);
  if (job.replace_pictures) folder.remove_pictures();
  require_same_run(folder, simulation);
  if (use_of(job) == FolderUse::shared)
    if (const int signal = agree(job, *pictures, folder, progress); signal != 0) return exit_code_after(signal);
  const std::string scene_text = resolved_toml(lit_scene(job.scene, simulation), limit_comments(simulation));
  // the record comes first: by it the folder is known as a run's, should the disk have no room for more
  RecordKeeper keeper(folder, options, scene_text, simulation, log);
  return do_recorded_stages({job, options, simulation, frames, folder, keeper, log, progress}, scene_text,
                            std::move(pictures));
}

}  // namespace umax
