#include "tools/tune/tuning.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/files/write_file.h"
#include "tools/run/run_record.h"
#include "tools/system/signals.h"
#include "tools/system/version.h"
#include "tools/trials/trial_names.h"
#include "tools/tune/measures.h"
#include "tools/tune/side_by_side.h"
#include "tools/tune/tune_page.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

enum class Stage { simulate, pictures };

/// Does the stage of all variants that lack it; results are of these, `done` are those that failed before.
class Runner {
 public:
  Runner(const TunePlan& plan, const TuneFolder& folder, const TrialOptions& options, Progress& progress)
      : plan_(plan),
        folder_(folder),
        progress_(progress),
        workers_(worker_options(options)),
        results_(plan.variants.size()),
        is_ours_(plan.variants.size(), 0) {}

  const std::vector<WorkResult>& results() const { return results_; }
  bool is_fine(std::size_t i) const { return results_[i].exit_code == 0; }

  void run(const std::vector<Scene>& scenes, Stage stage) {
    std::vector<WorkItem> items;
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      if (!is_fine(i)) continue;
      if (const auto item = item_for(plan_.variants[i].variant.name, scenes[i], stage, is_ours_[i])) {
        items.push_back(*item);
        indices.push_back(i);
      }
      is_ours_[i] = 1;
    }
    if (items.empty()) return;
    progress_.note(fmt::format("{} of {} variants to {}, {} at a time", items.size(), scenes.size(),
                               stage == Stage::simulate ? "simulate" : "make", count_workers(items, workers_)));
    const std::vector<WorkResult> results = run_workers(items, workers_, "tune", progress_);
    for (std::size_t k = 0; k < indices.size(); ++k) results_[indices[k]] = results[k];
  }

 private:
  std::optional<WorkItem> item_for(const std::string& name, const Scene& scene, Stage stage, bool is_ours) const {
    return missing_work({.name = name, .scene = folder_.scene(name), .run = folder_.run(name)}, scene,
                        {.last_frame = scene.clip.frames, .pictures = stage == Stage::pictures}, is_ours, progress_);
  }

  const TunePlan& plan_;
  const TuneFolder& folder_;
  Progress& progress_;
  WorkerOptions workers_;
  std::vector<WorkResult> results_;
  std::vector<char> is_ours_;  // run() has seen to it before
};

std::vector<Scene> scenes_of(const TunePlan& plan) {
  std::vector<Scene> scenes;
  for (const TuneVariant& one : plan.variants) scenes.push_back(one.scene);
  return scenes;
}

/// Whether the scene says where it is at all times.
bool is_given(const CameraDescription& camera) {
  return !camera.file.empty() || (camera.position && camera.target);
}

/// Where the scene does not say, all variants are seen by one camera that frames the motion of all.
void share_camera(const std::vector<VariantMeasures>& measures, std::vector<Scene>& scenes) {
  Box box;
  for (const VariantMeasures& one : measures) box.extend(one.box);
  for (Scene& scene : scenes) {
    if (is_given(scene.camera)) continue;
    const Camera camera = frame_camera(scene.camera, box, double(scene.render.width) / scene.render.height);
    if (!scene.camera.position) scene.camera.position = Vector3d(camera.position.cast<double>());
    if (!scene.camera.target) scene.camera.target = Vector3d(camera.target.cast<double>());
  }
}

/// Of all variants but those that failed; motions that have been measured before are not read again.
void measure_all(const std::vector<Scene>& scenes, const TunePlan& plan, const TuneFolder& folder, const Runner& runner,
                 std::vector<VariantMeasures>& measures) {
  measures.resize(scenes.size());
  ShapeLibrary library{.keeps_cages = true};
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (!runner.is_fine(i) || stop_signal() != 0) continue;
    const fs::path run = folder.run(plan.variants[i].variant.name);
    if (measures[i].hexes == 0) measures[i] = measure(scenes[i], run, library);
    if (const auto record = read_run_record(run / "run.json")) measures[i].wall_seconds = record->seconds();
  }
}

std::string list_of(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

TunePage describe(const TunePlan& plan, const std::vector<VariantMeasures>& measures, const Runner& runner) {
  const Scene& scene = plan.variants.front().scene;
  TunePage page;
  std::vector<std::string> keys, varied;
  std::vector<int> counts;
  for (const Variation& variation : plan.variations) keys.push_back(variation.keys.front());
  for (const Variation& variation : plan.variations) {
    page.keys.push_back(short_key(variation.keys.front(), keys));
    counts.push_back(int(variation.values.size()));
    varied.push_back(fmt::format("{} = {}", variation.keys.front(), list_of(variation.values)));
  }
  page.title = fmt::format("{}: {} variants", plan.scene_name, plan.variants.size());
  page.summary =
      fmt::format("{}.{}", fmt::join(varied, "; "),
                  plan.notes.empty() ? "" : " Preview: " + list_of(plan.notes) + "; --final for the scene as it is.");
  page.made_by = fmt::format("Made by umax {} on {}.", version_text(), host_description());
  page.columns = sheet_columns(int(plan.variants.size()), counts);
  page.num_frames = scene.clip.frames;
  page.substeps = scene.clip.substeps;
  page.fps = scene.clip.fps;
  page.worst_frame = worst_frame(measures);
  page.width = scene.render.width;
  page.height = scene.render.height;
  for (std::size_t i = 0; i < plan.variants.size(); ++i) {
    const TuneVariant& one = plan.variants[i];
    page.variants.push_back({.name = one.variant.name,
                             .label = one.variant.label,
                             .snippet = one.snippet,
                             .aim = one.aim,
                             .values = one.variant.values,
                             .exit_code = runner.results()[i].exit_code,
                             .failure = runner.results()[i].message,
                             .measures = measures[i]});
  }
  return page;
}

std::string sheet_title(const TunePage& page) {
  return fmt::format("{} at {:.2f} s (frame {}), where they are stretched most", page.title,
                     (page.worst_frame - 1) / page.fps, page.worst_frame);
}

/// Sheet, clip and page of the variants that are whole. False when a signal stopped it.
bool write_pages(TunePage page, const TuneFolder& folder, const std::string& library, Progress& progress) {
  std::vector<ShownVariant> shown;
  for (const PageVariant& variant : page.variants)
    if (variant.exit_code == 0) shown.push_back({variant.label, folder.run(variant.name)});
  folder.remove_pages();
  write_sheet(folder.sheet(), shown, page.worst_frame, page.columns, sheet_title(page));
  if (!write_mosaic(folder.clip(), shown, page.num_frames, page.columns, page.fps, progress)) return false;
  fit_page_pictures(page.width, page.height, (long long)(shown.size()) * page.num_frames);
  for (PageVariant& variant : page.variants)
    if (variant.exit_code == 0)
      variant.frames = page_frames(folder.run(variant.name), page.num_frames, page.width, page.height);
  write_file(folder.record(), tune_record(page));
  write_file(folder.page(), tune_page_html(page, library));
  for (const fs::path& file : {folder.sheet(), folder.clip(), folder.page()}) progress.note(file.string());
  return true;
}

int stopped(Progress& progress) {
  progress.note(stop_note(stop_signal()));
  return exit_code_after(stop_signal());
}

}  // namespace

int do_tuning(const TunePlan& plan, const TuneFolder& folder, const TrialOptions& options, Progress& progress) {
  const std::string library = plotting_library();
  Runner runner(plan, folder, options, progress);
  std::vector<Scene> scenes = scenes_of(plan);
  std::vector<VariantMeasures> measures;
  if (!std::all_of(scenes.begin(), scenes.end(), [](const Scene& scene) { return is_given(scene.camera); })) {
    runner.run(scenes, Stage::simulate);
    if (stop_signal() != 0) return stopped(progress);
    measure_all(scenes, plan, folder, runner, measures);
    share_camera(measures, scenes);
  }
  if (stop_signal() == 0) runner.run(scenes, Stage::pictures);
  if (stop_signal() != 0) return stopped(progress);
  measure_all(scenes, plan, folder, runner, measures);
  if (stop_signal() != 0) return stopped(progress);

  const auto failed = std::find_if(runner.results().begin(), runner.results().end(),
                                   [](const WorkResult& result) { return result.exit_code != 0; });
  const bool nothing_to_show = std::all_of(runner.results().begin(), runner.results().end(),
                                           [](const WorkResult& result) { return result.exit_code != 0; });
  if (!nothing_to_show && !write_pages(describe(plan, measures, runner), folder, library, progress))
    return stopped(progress);
  return failed == runner.results().end() ? 0 : failed->exit_code;
}

}  // namespace umax
