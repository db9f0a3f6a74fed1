// How far a limit means the same on a finer cage: settled shapes at 1, 2 and 4 times the cells along each edge.
#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>

#include "core/model/hex_limits.h"
#include "scenes/scene_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/setup/simulation_setup.h"

namespace umax {
namespace {

constexpr double exempt = 1e6;          // [-] on the limits of hexes that shall have none
constexpr double promised_change = 10;  // [%] from 2 to 4 times
constexpr std::array refinements{1, 2, 4};

struct Study {
  std::string scene;
  std::vector<std::string> settings;
  Vector3i cells{1, 1, 1};  // of the coarsest cage
  int steps = 0;            // until it rests
};

// lets hexes that hold a fixed node go as far as they like
void exempt_clamped_hexes(Model& model) {
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    for (int n = 0; n < 8; ++n)
      if (model.node_fixed[model.hexes(e, n)]) model.limit_factor[e] = exempt;
}

struct Settled {
  double position = 0;   // [m] what the study looks at: tip or centre, against rest
  double last_move = 0;  // [m] of it in the last step
  double seconds = 0;
  int hexes = 0, active = 0, not_converged = 0;
};

double height(const Simulation& simulation, const Points& positions) {
  if (!simulation.scene.probes.empty()) return probe_positions(simulation, positions)[0].y();
  return (simulation.model.node_mass.transpose() * positions)(1) / simulation.model.node_mass.sum();
}

Settled settle(const Study& study, int refinement, const std::string& measure, bool clamp_limited) {
  const Vector3i cells = refinement * study.cells;
  const std::string body = "body." + study.scene + ".";
  std::vector<Override> overrides{{body + "cage.cells", fmt::format("[{}, {}, {}]", cells[0], cells[1], cells[2])},
                                  {body + "limit.measure", measure}};
  // hard peaks need some 80 factorisations a step on the finest cage, soft ones 10, for nearly the same shape
  if (measure == "peak") overrides.push_back({body + "limit.kind", "soft"});
  for (const std::string& setting : study.settings) overrides.push_back(parse_override(body + setting));
  overrides.push_back({"clip.fps", "10"});
  Simulation simulation = set_up(load_scene(study.scene, overrides));
  if (!clamp_limited) exempt_clamped_hexes(simulation.model);

  const auto start = std::chrono::steady_clock::now();
  State state = rest_state(simulation.model);
  const double rest = height(simulation, state.positions);
  Workspace workspace(simulation.model);
  Settled settled{.hexes = int(simulation.model.num_hexes())};
  for (int i = 0; i < study.steps; ++i) {
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    const double now = height(simulation, state.positions) - rest;
    settled.last_move = std::abs(now - settled.position);
    settled.position = now;
    settled.active = report.limits_active;
    settled.not_converged += report.status != StepStatus::converged;
  }
  settled.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return settled;
}

BenchRows rows_of(const Study& study, const std::string& measure, bool clamp_limited) {
  BenchRows rows;
  const std::string what = fmt::format("{}, {}{}", study.scene, measure == "peak" ? "soft peak" : measure,
                                       clamp_limited ? "" : ", clamp free");
  double before = 0;
  for (const int refinement : refinements) {
    const Settled settled = settle(study, refinement, measure, clamp_limited);
    const double change = 100 * std::abs(settled.position / before - 1);
    BenchRow row{fmt::format("{}: {}x, {} hexes, {} at their limit", what, refinement, settled.hexes, settled.active),
                 fmt::format("{:.4f} m", settled.position), "", true};
    if (before != 0) row.measured += fmt::format(", {:.1f} % from the coarser", change);
    row.measured += fmt::format(" ({:.0f} s, still moving {:.1g} m)", settled.seconds, settled.last_move);
    if (settled.not_converged > 0) row.measured += fmt::format(", {} steps not converged", settled.not_converged);
    if (refinement == refinements.back() && clamp_limited) {
      row.target = fmt::format("<= {:.0f} % from 2x to 4x", promised_change);
      row.met = change <= promised_change;
    }
    rows.push_back(row);
    before = settled.position;
  }
  return rows;
}

BenchRows refinement() {
  const Study beam{"beam", {"limit.stretch=7.2%", "material.damping_mass=4"}, {14, 2, 2}, 30};
  // it falls by a centimetre and settles by damping
  const Study sphere{"sphere",
                     {"limit.stretch=15%", "material.damping_mass=8", "material.young=30kPa", "position=[0,1.01,0]"},
                     {3, 3, 3},
                     30};
  BenchRows rows;
  const auto add = [&rows](const BenchRows& more) { rows.insert(rows.end(), more.begin(), more.end()); };
  for (const char* measure : {"mean", "peak"}) {
    add(rows_of(beam, measure, true));
    add(rows_of(beam, measure, false));
    add(rows_of(sphere, measure, true));
  }
  return rows;
}

}  // namespace

std::vector<Benchmark> refinement_benchmarks() {
  return {{"refinement", true, false, refinement}};
}

}  // namespace umax
