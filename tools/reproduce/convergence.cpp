// Section 6.2: the true derivative of the limits against warped elastic forces.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "tools/reproduce/experiments.h"
#include "tools/reproduce/run_measures.h"

namespace umax {
namespace {

constexpr std::array energies{"0.5", "0.1", "0.05", "0.01"};  // [J]
constexpr std::array jacobians{"fixed_rotation", "warped", "exact"};
constexpr int fixed_rotation = 0, warped = 1;

/// A beam's first swing, means over the steps that had to be corrected.
struct Effort {
  double iterations = 0;  // a step
  double ms = 0;          // a step
  int steps = 0;
  int unconverged = 0;
};

/// The same run several times: every step does the same, so the least time is the one least disturbed.
Effort effort_of(const std::vector<Run>& repeats) {
  const std::vector<double>& iterations = repeats.front().column("sqp_iterations");
  Effort effort;
  effort.unconverged = num_unconverged(repeats.front());
  for (std::size_t i = 0; i < iterations.size(); ++i) {
    if (iterations[i] == 0) continue;
    double least = repeats.front().column("wall_ms")[i];
    for (const Run& run : repeats) least = std::min(least, run.column("wall_ms")[i]);
    effort.iterations += iterations[i];
    effort.ms += least;
    ++effort.steps;
  }
  effort.iterations /= std::max(1, effort.steps);
  effort.ms /= std::max(1, effort.steps);
  return effort;
}

using Efforts = std::array<std::array<Effort, jacobians.size()>, energies.size()>;

Efforts measure(Workbench& bench, const std::string& measure) {
  std::array<std::array<std::vector<Run>, jacobians.size()>, energies.size()> runs;
  const int num_repeats = bench.quick() ? 1 : 3;
  for (int repeat = 1; repeat <= num_repeats; ++repeat)
    for (std::size_t e = 0; e < energies.size(); ++e)
      for (std::size_t j = 0; j < jacobians.size(); ++j)
        runs[e][j].push_back(
            bench.simulate(fmt::format("convergence-{}-{}J-{}-{}", measure, energies[e], jacobians[j], repeat), "beam",
                           joined({published_way().settings,
                                   {"clip.fps=100", "clip.frames=81", "solver.energy=" + measure,
                                    fmt::format("solver.jacobian={}", jacobians[j]),
                                    fmt::format("body.beam.limit.energy={} J", energies[e])}})));
  Efforts efforts;
  for (std::size_t e = 0; e < energies.size(); ++e)
    for (std::size_t j = 0; j < jacobians.size(); ++j) efforts[e][j] = effort_of(runs[e][j]);
  return efforts;
}

double gain(double of_warped, double of_fixed) {
  return 100 * (of_warped / of_fixed - 1);
}

/// Iterations, or milliseconds, of the three derivatives and the gain of the paper's over the warped force.
ReportTable table_of(const Efforts& efforts, const std::string& name, const std::string& caption,
                     const std::string& unit, double Effort::* value) {
  ReportTable table{.name = name,
                    .caption = caption,
                    .columns = {{"paper's derivative (R fixed)", unit},
                                {"warped force", unit},
                                {"exact gradient", unit},
                                {"gain: warped / paper's - 1", "%"},
                                {"steps"},
                                {"not converged"}},
                    .rows = {}};
  double sum = 0, most = -100;
  for (std::size_t e = 0; e < energies.size(); ++e) {
    const auto& of = efforts[e];
    const double here = gain(of[warped].*value, of[fixed_rotation].*value);
    sum += here;
    most = std::max(most, here);
    int unconverged = 0;
    for (const Effort& effort : of) unconverged += effort.unconverged;
    table.rows.push_back(
        {fmt::format("U ≤ {} J", energies[e]),
         {number_cell(of[fixed_rotation].*value), number_cell(of[warped].*value), number_cell(of[2].*value),
          number_cell(here), number_cell(of[fixed_rotation].steps), number_cell(unconverged)}});
  }
  const ReportCell none{"–"};
  table.rows.push_back({"mean gain", {none, none, none, number_cell(sum / double(energies.size())), none, none}});
  table.rows.push_back({"largest gain", {none, none, none, number_cell(most), none, none}});
  return table;
}

}  // namespace

ReportSection convergence(Workbench& bench) {
  const Efforts paper = measure(bench, "paper"), true_energy = measure(bench, "true");
  ReportTable printed{.name = "printed",
                      .caption = "The gain that the paper prints; of what (iterations or time) it does not say.",
                      .columns = {{"gain", "%"}},
                      .rows = {{"mean", {number_cell(80.4)}}, {"largest", {number_cell(130.8, 4)}}}};
  ReportSection section{.name = "convergence", .title = "Section 6.2: convergence", .blocks = {}};
  section.blocks = {
      ReportText{
          "“We have used a compliant material (Y = 150KPa) with four different energy limits: Ue ≤ 0.5J, Ue ≤ "
          "0.1J, Ue ≤ 0.05J and Ue ≤ 0.01J. Our results show that true constraint derivatives provide better "
          "convergence, with an average performance gain of 80.4%. Moreover, this gain increases with the number "
          "of constraints, reaching a maximum of 130.8% in our tests.”",
          ReportVoice::paper},
      printed,
      table_of(
          paper, "paper-energy-iterations",
          "The paper's energy (Eq. 16): re-linearisations a step, over the steps of the first 0.8 s that needed any",
          "", &Effort::iterations),
      table_of(paper, "paper-energy-time", "The paper's energy: time of these steps", "ms", &Effort::ms),
      table_of(true_energy, "true-energy-iterations", "The true energy: re-linearisations a step", "",
               &Effort::iterations),
      table_of(true_energy, "true-energy-time", "The true energy: time of these steps", "ms", &Effort::ms),
      ReportText{
          "with the paper's energy the gain is of the size that the paper reports, and grows as it says. It is no "
          "merit of the derivative, though: the warped force is the R-fixed derivative of the true energy, "
          "½ σ:ε, while Eq. 16 counts the normal part twice; the warped force is therefore too short by a factor "
          "between 1 and 2 as a derivative of THAT energy, and each iteration overshoots. Where the limit "
          "measures the true energy, both are the same vector: the same iterations, and a gain in time that is "
          "nothing but the clock's noise. Letting R move (exact gradient) changes little.",
          ReportVoice::difference}};
  return section;
}

}  // namespace umax
