#include "core/step/pinned_model.h"

#include <algorithm>
#include <utility>

#include "core/model/pins.h"
#include "core/step/islands.h"

namespace umax {
namespace {

constexpr double no_limit = 1e12;  // [-] on the limits of hexes that nothing can move

Model with_driven_nodes(const Model& model, const std::vector<std::vector<char>>& active) {
  Model pinned = model;
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].pins)
      for (const int node : model.bodies[b].pins->driven_nodes(active[b]))
        pinned.node_fixed[std::size_t(model.bodies[b].first_node + node)] = 1;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    const auto nodes = model.hexes.row(e);
    if (std::all_of(nodes.begin(), nodes.end(), [&](int node) { return pinned.node_fixed[std::size_t(node)] != 0; }))
      pinned.limit_factor[e] *= no_limit;
  }
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

}  // namespace umax
