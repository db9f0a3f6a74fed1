#include "core/step/measurement.h"

#include <algorithm>
#include <memory>

#include "core/base/parallel.h"
#include "core/contact/clearances.h"
#include "core/contact/surface_overlap.h"
#include "core/model/hex_batches.h"
#include "core/model/hex_limits.h"
#include "core/problem/step_problem.h"
#include "core/step/islands.h"

namespace umax {
namespace {

// kinetic, elastic (true energy, whatever the limit measures) and gravitational energy
void measure_energies(const Model& model, const StepOptions& options, const State& state, StepReport& report) {
  report.kinetic_energy = report.potential_energy = report.elastic_energy = 0;
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
    report.kinetic_energy += 0.5 * model.node_mass[node] * state.velocities.row(node).squaredNorm();
    report.potential_energy -= model.node_mass[node] * state.positions.row(node).dot(options.gravity.transpose());
  }
  VectorXd elastic(model.num_hexes());
  parallel_blocks(model.num_hexes(), 64, [&](Eigen::Index begin, Eigen::Index end) {
    evaluate_hexes(model, options.solver.rotation, state.positions, begin, end,
                   [&](Eigen::Index e, const HexBatch& batch, int lane) {
                     elastic[e] = elastic_energy(young_at(model, e, state.time), batch, lane);
                   });
  });
  for (const double energy : elastic) report.elastic_energy += energy;
}

// What searches remember that a measurement at the positions may start from: those of the solution, where all bodies were
// solved together, know them already. Else those of the measurements before.
std::shared_ptr<Clearances> known_at(const Points& positions, Workspace::Data& data) {
  if (data.clearances && data.clearances->positions.rows() == positions.rows() &&
      data.clearances->positions == positions)
    return data.clearances;
  if (!data.measured) data.measured = std::make_shared<Clearances>();
  return data.measured;
}

// how deep surface vertices are inside other bodies, or other parts of their own, at most [m]
double deepest_in_bodies(const Model& model, const Points& positions, Workspace::Data& data) {
  if (data.islands.empty())
    return max_surface_penetration(model, data.contact_geometry, positions, known_at(positions, data));
  double deepest = deepest_across(model, data.contact_geometry, positions, data.islands);
  for (const std::unique_ptr<Island>& island : data.islands)
    deepest =
        std::max(deepest, deepest_in_bodies(island->model, part_of(model, positions, *island), island->workspace));
  return deepest;
}

// in_bodies: [m] as of deepest_in_bodies()
void measure_with(const Model& model, const StepOptions& options, const ContactGeometry& geometry, const State& state,
                  double in_bodies, StepReport& report) {
  report.max_energy_ratio = model.num_hexes() ? energy_ratios(model, options.solver, state).maxCoeff() : 0;
  report.max_penetration = std::max(max_penetration(model, geometry, state.positions, state.time), in_bodies);
  measure_energies(model, options, state, report);
}

}  // namespace

void measure_into(const Model& model, const StepOptions& options, const State& state, Workspace::Data& data,
                  StepReport& report) {
  measure_with(model, options, data.contact_geometry, state, deepest_in_bodies(model, state.positions, data), report);
}

StepReport measure(const Model& model, const StepOptions& options, const State& state) {
  StepReport report;
  const ContactGeometry geometry = make_contact_geometry(model);
  measure_with(model, options, geometry, state, max_surface_penetration(model, geometry, state.positions), report);
  return report;
}

std::vector<Overlap> find_overlaps(const Model& model, const State& state) {
  std::vector<Overlap> overlaps = find_overlaps(model, make_contact_geometry(model), state.positions);
  std::erase_if(overlaps, [&](const Overlap& overlap) {
    return overlap.depth <= tolerance_depth(model, model.bodies[overlap.a].first_hex);
  });
  return overlaps;
}

VectorXd overlap_depths(const Model& model, const State& state) {
  VectorXd depths = overlap_depths(model, make_contact_geometry(model), state.positions);
  for (Eigen::Index p = 0; p < depths.size(); ++p)
    if (depths[p] <= tolerance_depth(model, surface_hex(model, p))) depths[p] = 0;
  return depths;
}

VectorXd energy_ratios(const Model& model, const SolverOptions& solver, const State& state) {
  return largest_by_hex(model, limit_ratios(model, solver, materials_at(model, state.time), state.positions));
}

}  // namespace umax
