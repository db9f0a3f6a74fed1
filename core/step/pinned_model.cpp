#include "core/step/pinned_model.h"

#include <algorithm>
#include <utility>

#include "core/model/pins.h"
#include "core/problem/step_pins.h"
#include "core/problem/step_problem.h"
#include "core/step/islands.h"

namespace umax {
namespace {

constexpr double no_limit = 1e12;  // [-] on the limits of hexes that nothing can move, or that pins tear
constexpr double rounding = 5e-6;  // [cells] that springs of exact points may give way

// the hexes' factors on limits; of those without a free node, next to none
VectorXd free_factors(const Model& model, const Model& pinned) {
  VectorXd factors = model.limit_factor;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    const auto nodes = model.hexes.row(e);
    if (std::all_of(nodes.begin(), nodes.end(), [&](int node) { return pinned.node_fixed[std::size_t(node)] != 0; }))
      factors[e] *= no_limit;
  }
  return factors;
}

Model with_driven_nodes(const Model& model, const std::vector<std::vector<char>>& active) {
  Model pinned = model;
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].pins)
      for (const int node : model.bodies[b].pins->driven_nodes(active[b]))
        pinned.node_fixed[std::size_t(model.bodies[b].first_node + node)] = 1;
  pinned.limit_factor = free_factors(model, pinned);
  return pinned;
}

}  // namespace

const Model& pinned_model(const Model& model, double time, Workspace::Data& workspace) {
  std::vector<std::vector<char>> active(model.bodies.size());
  bool any = false;
  for (std::size_t b = 0; b < active.size(); ++b)
    if (model.bodies[b].pins) active[b] = model.bodies[b].pins->active_at(time), any = true;
  if (!any) return model;
  if (active != workspace.active_pins || !workspace.pinned) {
    workspace.pinned = std::make_unique<Model>(with_driven_nodes(model, active));
    workspace.active_pins = std::move(active);
    workspace.bodies = std::vector<DirectSystem>(model.bodies.size());
    workspace.all = {};
    workspace.multigrid.reset();
    workspace.islands.clear();
  }
  return *workspace.pinned;
}

MissedPins missed_pins(const Model& model, const StepOptions& options, const Points& positions, double time) {
  const auto has_springs = [&](const Model::BodyRange& body) {
    return body.pins && body.pins->has_springs(body.pins->active_at(time));
  };
  if (std::none_of(model.bodies.begin(), model.bodies.end(), has_springs)) return {};
  const StepPins pins = pins_at(model, {}, materials_at(model, time).young, time, options.time_step);
  MissedPins all;
  for (const PinSpring& spring : pins.springs) {
    if (!spring.is_exact) continue;
    const double size = body_of(model, spring.hex).cell_size, distance = missed(model, spring, positions).norm() / size;
    if (distance <= rounding) continue;
    if (all.hexes.empty() || all.hexes.back() != spring.hex) all.hexes.push_back(spring.hex);
    all.farthest = std::max(all.farthest, distance);
  }
  return all;
}

void put_limits_aside(const Model& model, const std::vector<int>& hexes, Workspace::Data& workspace) {
  VectorXd factors = free_factors(model, *workspace.pinned);
  for (const int hex : hexes) factors[hex] *= no_limit;
  if (factors == workspace.pinned->limit_factor) return;
  workspace.pinned->limit_factor = std::move(factors);
  workspace.islands.clear();  // they have copies
}

std::vector<int> with_neighbours(const Model& model, const std::vector<int>& hexes) {
  std::vector<char> touched(std::size_t(model.num_nodes()), 0);
  for (const int hex : hexes)
    for (int n = 0; n < 8; ++n) touched[std::size_t(model.hexes(hex, n))] = 1;
  std::vector<int> all;
  for (int e = 0; e < int(model.num_hexes()); ++e) {
    const auto nodes = model.hexes.row(e);
    if (std::any_of(nodes.begin(), nodes.end(), [&](int node) { return touched[std::size_t(node)] != 0; }))
      all.push_back(e);
  }
  return all;
}

}  // namespace umax
