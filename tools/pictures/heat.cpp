#include "tools/pictures/heat.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/element/material.h"
#include "render/annotation/annotate.h"

namespace umax {
namespace {

/// [%] uniaxial stretch of this energy [J] in a hex.
double percent_stretch(const Model& model, Eigen::Index hex, double time, double energy) {
  const double volume = model.shapes[model.hex_shape[hex]].volume;
  return 100 * stretch_from_density(young_at(model, hex, time), energy / volume);
}

VectorXd stretches(const Model& model, RotationEstimate rotation, const State& state) {
  VectorXd values(model.num_hexes());
  parallel_blocks(model.num_hexes(), 64, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const CorotatedHex hex = corotate(shape, rotation, hex_nodes(model, state.positions, e));
      const double energy = elastic_energy(shape.stiffness, young_at(model, e, state.time), hex);
      values[e] = percent_stretch(model, e, state.time, std::max(energy, 0.0));  // rounding may leave it below 0
    }
  });
  return values;
}

VectorXd multiplier_ratios(const Model& model, const State& state) {
  VectorXd values = VectorXd::Zero(model.num_hexes());
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    std::array<double, num_energy_parts> factors{};
    for (int l = model.limit_starts[e]; l < model.limit_starts[e + 1]; ++l) {
      const EnergyPart part = model.limits[l].part;
      factors[int(part)] += state.limit_multipliers[l] / energy_limit_at(model, e, state.time, part);
    }
    values[e] = *std::max_element(factors.begin(), factors.end());
  }
  return values;
}

/// The limit [%] of what the map of stretches shows; infinity: none, or it bounds something else.
double shown_stretch_limit(const Model& model, Eigen::Index hex, double time) {
  if (body_of(model, hex).limit.measure == LimitMeasure::peak) return std::numeric_limits<double>::infinity();
  return percent_stretch(model, hex, time, energy_limit_at(model, hex, time));
}

/// The next of 1, 2, 5, 10, 20 ... from `value` on, at least 1.
double rounded_up(double value) {
  // tick_step() takes what is within 80 %
  return value <= 1 ? 1 : tick_step(value / 0.8, 1);
}

Legend stretch_legend(const Simulation& simulation, const HeatRange& range) {
  Legend legend{.title = "stretch [%]"};
  const bool shared = std::isfinite(range.largest_limit) && range.largest_limit > 0 &&
                      range.largest_limit - range.least_limit <= 1e-6 * range.largest_limit;
  legend.ends_at_limit = shared && simulation.options.solver.energy == EnergyMeasure::true_energy;
  if (legend.ends_at_limit) {
    legend.high = range.largest_limit;
    legend.slack = 0.5 * simulation.options.solver.tolerance;  // U goes with the square
    return legend;
  }
  const double largest = std::max(range.largest, 1e-3), step = tick_step(largest);
  legend.high = std::ceil(largest / step - 1e-9) * step;
  return legend;
}

}  // namespace

VectorXd heat_values(const Simulation& simulation, const State& state) {
  return heat_values(simulation, state, simulation.scene.render.heatmap);
}

VectorXd heat_values(const Simulation& simulation, const State& state, Heatmap map) {
  const SolverOptions& solver = simulation.options.solver;
  switch (map) {
    case Heatmap::none:
      break;
    case Heatmap::energy:
      return energy_ratios(simulation.model, solver, state);
    case Heatmap::multiplier:
      return multiplier_ratios(simulation.model, state);
    case Heatmap::stretch:
      return stretches(simulation.model, solver.rotation, state);
  }
  return {};
}

void extend(HeatRange& range, const Simulation& simulation, const State& state) {
  const Heatmap map = simulation.scene.render.heatmap;
  if (map != Heatmap::multiplier && map != Heatmap::stretch) return;  // the others have a bar of their own
  const VectorXd values = heat_values(simulation, state);
  for (Eigen::Index e = 0; e < values.size(); ++e) {
    range.largest = std::max(range.largest, values[e]);
    const double limit = shown_stretch_limit(simulation.model, e, state.time);
    range.least_limit = std::min(range.least_limit, limit);
    range.largest_limit = std::max(range.largest_limit, limit);
  }
}

std::optional<Legend> heat_legend(const Simulation& simulation, const HeatRange& range) {
  const std::optional<double>& top = simulation.scene.render.heatmap_top;
  switch (simulation.scene.render.heatmap) {
    case Heatmap::none:
      break;
    case Heatmap::energy:
      return Legend{.title = "U / U_max", .ends_at_limit = true, .slack = simulation.options.solver.tolerance};
    case Heatmap::multiplier:
      return Legend{.title = "lambda / U_max", .high = top.value_or(rounded_up(range.largest)), .logarithmic = true};
    case Heatmap::stretch:
      return top ? Legend{.title = "stretch [%]", .high = *top} : stretch_legend(simulation, range);
  }
  return {};
}

}  // namespace umax
