#include "tools/aim/aim_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "tools/pictures/painter.h"
#include "tools/pictures/plot.h"
#include "tools/pictures/strip.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace {

/// The unit that values of a want are drawn in, and how many of it one is.
struct DrawnUnit {
  const char* name;
  double factor;
};

DrawnUnit unit_of(const Want& want) {
  if (want.measure == MeasureKind::rest) return {"s", 1};
  if (want.is_share || want.measure == MeasureKind::squash || want.measure == MeasureKind::stretch) return {"%", 100};
  return {"m", 1};
}

PlotPanel panel_of(const AimPlan& plan, std::size_t key, std::size_t index, const AimRuns& runs, const AimRun& best) {
  const Want& want = plan.wants[index];
  const DrawnUnit unit = unit_of(want);
  const KeyRange& range = plan.keys[key];
  std::vector<std::pair<double, double>> points;
  const auto point_of = [&](const AimRun& run) {
    return std::pair(range.value_at(run.place[Eigen::Index(key)]) / range.unit_size,
                     run.readings[index].value * unit.factor);
  };
  for (const AimRun& run : runs.all())
    if (run.place.size() > 0) points.push_back(point_of(run));
  std::sort(points.begin(), points.end());
  PlotSeries line, dots{.name = "runs", .style = PlotStyle::points},
      found{
          .name = "the nearest", .x = {point_of(best).first}, .y = {point_of(best).second}, .style = PlotStyle::points};
  line.name = "between them";
  for (const auto& [x, y] : points) dots.x.push_back(x), dots.y.push_back(y);
  line.x = dots.x, line.y = dots.y;
  PlotPanel panel;
  panel.y.label = fmt::format("{} [{}]", want.name, unit.name);
  if (plan.keys.size() == 1) panel.series.push_back(line);
  panel.series.insert(panel.series.end(), {dots, found});
  panel.levels = {{.name = "wanted: " + value_text(want, want.value), .y = want.value * unit.factor}};
  return panel;
}

/// The frames of the wants, as the best run has them, each once.
std::vector<int> frames_of(const AimRun& best) {
  std::vector<int> frames;
  for (const Reading& reading : best.readings)
    if (std::find(frames.begin(), frames.end(), reading.frame) == frames.end()) frames.push_back(reading.frame);
  return frames;
}

/// The scene's pictures, but wide enough for several bodies unless the user says how large.
RenderDescription strip_render(const AimPlan& plan) {
  constexpr int least_width = 1280;
  RenderDescription render = plan.scene.render;
  const auto& settings = plan.request.settings;
  const bool is_chosen = std::any_of(settings.begin(), settings.end(),
                                     [](const Override& setting) { return setting.key == "render.size"; });
  if (is_chosen || render.width >= least_width) return render;
  render.height = render.height * least_width / render.width;
  render.width = least_width;
  return render;
}

}  // namespace

std::string draw_aim_plot(const AimPlan& plan, std::size_t key, const AimRuns& runs, const AimRun& best) {
  const KeyRange& range = plan.keys[key];
  Plot plot;
  plot.title = plan.scene.name + ": what is wanted against " + range.key;
  plot.x.label = range.key + (range.unit.empty() ? "" : " [" + range.unit + "]");
  plot.x.logarithmic = range.logarithmic;
  for (std::size_t w = 0; w < plan.wants.size(); ++w) plot.panels.push_back(panel_of(plan, key, w, runs, best));
  return draw_svg(plot);
}

bool write_before_after(const AimPlan& plan, const AimFolder& folder, const AimRuns& runs, const AimRun& best,
                        int threads) {
  std::vector<const AimRun*> shown{&runs.all().front()};
  if (!best.is_before()) shown.push_back(&best);
  ShapeLibrary library{.keeps_cages = true};
  std::vector<std::shared_ptr<const Simulation>> simulations;
  for (const AimRun* run : shown)
    simulations.push_back(std::make_shared<const Simulation>(set_up(run->scene, library)));
  std::vector<StripItem> items;
  for (const int frame : frames_of(best))
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const Simulation& simulation = *simulations[i];
      const std::string moment = fmt::format(", {:.2f} s", (frame - 1) / plan.scene.clip.fps);
      items.push_back({simulations[i],
                       read_state(state_path(folder.run(shown[i]->name), frame), simulation.model, simulation.digest),
                       (i == 0 ? "before" : "after") + moment});
    }
  const RenderDescription render = strip_render(plan);
  return Painter(render, threads).paint(make_strip(items, double(render.width) / render.height), folder.strip());
}

}  // namespace umax
