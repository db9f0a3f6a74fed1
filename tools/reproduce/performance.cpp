// Section 6.2: what a frame of the armadillo costs.
#include <fmt/format.h>

#include <algorithm>

#include "tools/reproduce/character.h"
#include "tools/reproduce/experiments.h"
#include "tools/reproduce/run_measures.h"

namespace umax {
namespace {

constexpr int timed_steps = 250;

/// Means over the steps of a run, and over those with a contact or an active limit.
struct Cost {
  double ms = 0, active_ms = 0;               // a step
  double constraints = 0, energy_limits = 0;  // an active step: contacts and limits together; limits alone
  int active_steps = 0;
};

Cost cost_of(const Run& run) {
  Cost cost;
  const auto &ms = run.column("wall_ms"), &limits = run.column("limits_active"), &contacts = run.column("contacts");
  for (std::size_t i = 0; i < ms.size(); ++i) {
    cost.ms += ms[i] / double(ms.size());
    if (limits[i] + contacts[i] == 0) continue;
    ++cost.active_steps;
    cost.active_ms += ms[i];
    cost.constraints += limits[i] + contacts[i];
    cost.energy_limits += limits[i];
  }
  const double active = std::max(1, cost.active_steps);
  cost.active_ms /= active;
  cost.constraints /= active;
  cost.energy_limits /= active;
  return cost;
}

ReportRow row_of(const std::string& name, const Run& run) {
  const Cost cost = cost_of(run);
  return {
      name,
      {number_cell(cost.ms), number_cell(cost.active_ms), number_cell(cost.active_steps), number_cell(cost.constraints),
       number_cell(3 * cost.constraints - 2 * cost.energy_limits), number_cell(cost.energy_limits),
       number_cell(largest(run.column("max_energy_ratio")), 5), number_cell(num_unconverged(run))}};
}

ReportPlot time_plot(const std::vector<Run>& runs, const std::vector<Variant>& ways) {
  ReportPlot plot{.plot = {.title = "Computing time and constraints, step by step"},
                  .caption = "Time of a step, and contacts and active energy limits in it."};
  plot.plot.x.label = "simulated time [s]";
  PlotPanel times, constraints;
  times.y = {.label = "time of a step [ms]", .logarithmic = true};
  constraints.y = {.label = "constraints", .whole_numbers = true, .low = 0};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    times.series.push_back({ways[i].label, runs[i].column("time_s"), runs[i].column("wall_ms")});
    PlotSeries all{ways[i].label, runs[i].column("time_s"), runs[i].column("contacts")};
    for (std::size_t s = 0; s < all.y.size(); ++s) all.y[s] += runs[i].column("limits_active")[s];
    constraints.series.push_back(all);
  }
  times.levels = {{"the paper's mean: 512.5 ms", 512.5}};
  plot.plot.panels = {times, constraints};
  return plot;
}

}  // namespace

ReportSection performance(Workbench& bench) {
  const Character character = character_of(bench);
  const std::vector<Variant> ways{published_way(), exact_way()};
  std::vector<Run> runs;
  for (const Variant& way : ways)
    runs.push_back(bench.simulate(
        "performance-" + way.name, character.scene,
        joined({character.settings, way.settings, {"clip.fps=100", fmt::format("clip.frames={}", timed_steps + 1)}})));

  ReportTable table{.name = "cost",
                    .caption = fmt::format("{}: {} frames of one step of 0.01 s, 500 kPa, U ≤ 100 J, from 2 m. "
                                           "“Active” are the steps with a contact or an active limit.",
                                           character.label, timed_steps),
                    .columns = {{"a frame", "ms"},
                                {"an active frame", "ms"},
                                {"active frames"},
                                {"constraints in it"},
                                {"its rows, three a contact"},
                                {"energy limits among them"},
                                {"largest U/U_max"},
                                {"steps not converged"}},
                    .rows = {{"the paper (2.4 GHz i7-3517U)",
                              {number_cell(512.5, 4),
                               number_cell(520.59, 5),
                               {"–"},
                               number_cell(35.19, 4),
                               {"–"},
                               number_cell(6.36, 3),
                               {"not said"},
                               {"not said"}}}}};
  for (std::size_t i = 0; i < runs.size(); ++i) table.rows.push_back(row_of(ways[i].label, runs[i]));

  ReportSection section{.name = "performance", .title = "Section 6.2: performance", .blocks = {}};
  section.blocks = {
      ReportText{"“Our method took a total of 128.125s to simulate the 250 frames of the animation, with an average "
                 "time per frame of 512.5ms. Considering only frames with active constraints, the average number of "
                 "contraints was 35.19, with only 6.36 energy-limiting constraints. In those frames, the average "
                 "solving time per frame was 520.59 ms.”",
                 ReportVoice::paper},
      table, time_plot(runs, ways),
      ReportText{
          "another machine, ten years younger, and another implementation: the times are not the method's alone. "
          "The pose, the height of the fall and what counts as a constraint are not printed; here a contact is "
          "one (with its friction), and a limit is one while its multiplier pushes. The exact method counts the "
          "limits that carry load at the solution; the paper's pipeline all that pushed at some iteration.",
          ReportVoice::difference}};
  if (!bench.has_armadillo()) section.blocks.push_back(ReportText{stand_in_note(), ReportVoice::difference});
  return section;
}

}  // namespace umax
