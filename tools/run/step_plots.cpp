#include "tools/run/step_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "core/files/write_file.h"
#include "scenes/scene.h"
#include "tools/pictures/plot.h"
#include "tools/run/run_folder.h"
#include "tools/run/steps_csv.h"
#include "tools/setup/simulation_setup.h"

namespace umax {
namespace {

PlotSeries over_time(const StepsFound& steps, const std::string& name, const std::string& column) {
  return {.name = name, .x = steps.columns.at("time_s"), .y = steps.columns.at(column)};
}

PlotSeries total_energy(const StepsFound& steps) {
  PlotSeries total = over_time(steps, "total", "kinetic_energy_J");
  for (const char* column : {"elastic_energy_J", "potential_energy_J"})
    std::transform(total.y.begin(), total.y.end(), steps.columns.at(column).begin(), total.y.begin(), std::plus());
  total.style = PlotStyle::dashed;
  return total;
}

PlotPanel panel_of(const std::string& label, const std::vector<PlotSeries>& series) {
  PlotPanel panel;
  panel.y.label = label;
  panel.series = series;
  return panel;
}

PlotPanel energies(const StepsFound& steps) {
  return panel_of("energy [J]",
                  {over_time(steps, "kinetic", "kinetic_energy_J"), over_time(steps, "elastic", "elastic_energy_J"),
                   over_time(steps, "potential", "potential_energy_J"), total_energy(steps)});
}

/// U/U_max over its whole range and, where a limit is reached, what is left of it or passes it, at the scale of the
/// tolerance.
std::vector<PlotPanel> energy_ratio(const StepsFound& steps, double tolerance) {
  constexpr double most_linear = 10;  // beyond, as where a limit tightens on a bent body, the limit itself would vanish
  const PlotSeries ratio = over_time(steps, "largest U/U_max of all hexes", "max_energy_ratio");
  const double largest = ratio.y.empty() ? 0 : *std::max_element(ratio.y.begin(), ratio.y.end());
  PlotPanel whole = panel_of("U/U_max", {ratio});
  whole.levels = {{fmt::format("1 + solver.tolerance = {:g}", 1 + tolerance), 1 + tolerance}};
  whole.y.logarithmic = largest > most_linear;
  whole.y.low = whole.y.logarithmic ? 0.01 : 0;
  if (largest < 1 - 2 * tolerance) return {whole};

  PlotPanel near_limit = panel_of("U/U_max − 1", {ratio});
  near_limit.series[0].name = "the same, less 1";
  for (double& y : near_limit.series[0].y) y -= 1;
  near_limit.levels = {{"solver.tolerance", tolerance}};
  near_limit.y.high = tolerance * std::clamp(1.1 * (largest - 1) / tolerance, 2.0, 10.0);
  near_limit.y.low = -*near_limit.y.high;
  near_limit.height = 130;
  return {whole, near_limit};
}

PlotPanel count(const StepsFound& steps, const std::string& label, const std::string& column) {
  PlotPanel panel = panel_of(label, {over_time(steps, label, column)});
  panel.y.whole_numbers = true;
  panel.y.low = 0;
  return panel;
}

PlotPanel step_time(const StepsFound& steps) {
  PlotPanel panel = panel_of("wall-clock time of a step [ms]", {over_time(steps, "each step", "wall_ms")});
  panel.y.logarithmic = true;
  const std::vector<double>& times = panel.series[0].y;
  if (times.empty()) return panel;
  const double mean = std::accumulate(times.begin(), times.end(), 0.0) / double(times.size());
  panel.levels = {{fmt::format("mean: {:.3g} ms", mean), mean}};
  return panel;
}

/// What all plots of a run have in common.
Plot plot_of(const Scene& scene, const StepsFound& steps, const std::string& title, std::vector<PlotPanel> panels) {
  PlotMarks& marks = panels.front().marks;
  marks.name = "step did not converge";
  for (std::size_t i = 0; i < steps.converged.size(); ++i)
    if (!steps.converged[i]) marks.x.push_back(steps.columns.at("time_s")[i]);
  Plot plot{.title = scene.name + ": " + title, .panels = std::move(panels)};
  plot.x.label = "simulated time [s]";
  plot.x.low = 0;
  return plot;
}

}  // namespace

void write_step_plots(const RunFolder& folder, const Scene& scene) {
  const StepsFound steps = read_steps(folder.steps(), steps_header(probe_names(scene)));
  const std::array plots{
      plot_of(scene, steps, "energies", {energies(steps)}),
      plot_of(scene, steps, "energy of the hex nearest its limit", energy_ratio(steps, scene.solver.tolerance)),
      plot_of(scene, steps, "active limits", {count(steps, "hexes at their limit", "limits_active")}),
      plot_of(scene, steps, "contacts", {count(steps, "contacts", "contacts")}),
      plot_of(scene, steps, "computing time", {step_time(steps)})};
  static_assert(plots.size() == step_plot_names.size());
  create_folder(folder.plots());
  for (std::size_t i = 0; i < plots.size(); ++i) write_file(folder.plots() / step_plot_names[i], draw_svg(plots[i]));
}

}  // namespace umax
