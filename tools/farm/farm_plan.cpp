#include "tools/farm/farm_plan.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tools/run/clip.h"
#include "tools/setup/body_contact.h"
#include "tools/setup/simulation_setup.h"
#include "tools/trials/variants.h"

namespace umax {
namespace {

/// What a run is called, and what is set for it alone.
struct NamedSettings {
  std::string name;
  std::vector<Override> settings;
};

std::vector<NamedSettings> runs_of(const FarmRequest& request, const std::string& scene_name) {
  if (request.variations.empty()) return {{scene_name, {}}};
  std::vector<Variation> variations;
  for (const std::string& text : request.variations) variations.push_back(parse_variation(text));
  std::vector<NamedSettings> runs;
  for (const SceneVariant& variant : combinations(variations)) runs.push_back({variant.name, variant.settings});
  return runs;
}

/// What would end the run's first job.
void require_sound(const Scene& scene) {
  require_even_size(scene.render.width, scene.render.height);
  const Simulation simulation = set_up(scene);
  if (!scene.clip.allow_overlap) require_clear_start(simulation.model);
}

void require_same_length(const FarmPlan& plan, const Scene& scene) {
  if (plan.runs.empty() || plan.num_frames == scene.clip.frames) return;
  throw Error(Fault::usage, {.where = "--vary",
                             .what = "gives runs of different lengths, which do not have the same chunks",
                             .value = fmt::format("{} and {} frames", plan.num_frames, scene.clip.frames),
                             .remedy = "call umax farm once for each length"});
}

FarmJob simulation_of(const FarmPlan& plan) {
  return {.name = "simulate", .script = "simulate.sh", .words = {"task"}, .tasks = int(plan.runs.size())};
}

}  // namespace

FarmPlan plan_farm(const FarmRequest& request) {
  const Scene base = load_scene(request.scene, request.settings);
  FarmPlan plan;
  plan.name = base.name;
  plan.is_varied = !request.variations.empty();
  plan.frames_per_job = request.frames_per_job;
  plan.processors = request.processors;
  plan.memory = request.memory.value_or(0);
  plan.deadline = request.deadline;
  plan.isa = request.isa.value_or("");
  for (const NamedSettings& run : runs_of(request, base.name)) {
    std::vector<Override> settings = request.settings;
    settings.insert(settings.end(), run.settings.begin(), run.settings.end());
    const Scene scene = load_scene(request.scene, settings);
    require_same_length(plan, scene);
    require_sound(scene);
    plan.num_frames = scene.clip.frames;
    plan.runs.push_back({.name = run.name, .scene = resolved_toml(scene), .title = scene.name});
  }
  return plan;
}

std::vector<FarmJob> jobs_of(const FarmPlan& plan) {
  std::vector<FarmJob> jobs{simulation_of(plan)};
  const int num_runs = int(plan.runs.size());
  FarmJob encode{.name = "encode", .script = "encode.sh", .words = {"task"}, .tasks = num_runs};
  if (!plan.is_varied) {
    jobs.push_back({.name = "render",
                    .script = "render.sh",
                    .words = {"1", "task"},
                    .tasks = plan.num_chunks(),
                    .waiting = Waiting::for_all,
                    .after = {0}});
    encode.waiting = Waiting::for_all;
    encode.after = {1};
  } else {
    for (int chunk = 1; chunk <= plan.num_chunks(); ++chunk) {
      encode.after.push_back(jobs.size());
      jobs.push_back({.name = fmt::format("render-{}", chunk),
                      .script = "render.sh",
                      .words = {"task", std::to_string(chunk)},
                      .tasks = num_runs,
                      .waiting = Waiting::for_each,
                      .after = {0}});
    }
    encode.waiting = Waiting::for_each;
  }
  jobs.push_back(encode);
  return jobs;
}

}  // namespace umax
