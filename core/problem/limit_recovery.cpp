#include "core/problem/limit_recovery.h"

#include <algorithm>
#include <cmath>

#include "core/element/material.h"
#include "core/model/pins.h"

namespace umax {
namespace {

constexpr double recovery_speed = 0.5;  // [1/s] of stretch
constexpr double recovery_time = 2;     // [s] from when a pin lets go; longer where none is left

// each limit's hex is of a body that has been let go in the step that ends at the time
std::vector<char> limits_let_go(const Model& model, double time) {
  std::vector<char> of_body;
  for (const Model::BodyRange& body : model.bodies) of_body.push_back(is_let_go(body, time) ? 1 : 0);
  std::vector<char> of_limit;
  for (const HexLimit& limit : model.limits)
    of_limit.push_back(of_body[std::size_t(model.hex_body[limit.hex])] && limit.kind == LimitKind::hard ? 1 : 0);
  return of_limit;
}

bool any(const std::vector<char>& flags) {
  return std::any_of(flags.begin(), flags.end(), [](char flag) { return flag != 0; });
}

}  // namespace

bool is_let_go(const Model::BodyRange& body, double time) {
  if (!body.pins) return false;
  int active = 0;
  bool ever = false, lately = false;
  for (const Pin& pin : body.pins->pins()) {
    active += pin.is_active(time);
    const bool has_let_go = pin.from < time && pin.until < time;
    ever = ever || has_let_go;
    lately = lately || (has_let_go && pin.until >= time - recovery_time);
  }
  return active == 0 ? ever : active == 1 && lately;
}

VectorXd recovering_limits(const Model& model, const SolverOptions& solver, const State& state, double h,
                           const Materials& at_end) {
  VectorXd limits = at_end.limits;
  const std::vector<char> let_go = limits_let_go(model, state.time + h);
  if (!state.been_feasible || !any(let_go)) return limits;
  const VectorXd ratios = limit_ratios(model, solver, at_end, state.positions);
  for (Eigen::Index l = 0; l < limits.size(); ++l) {
    if (!let_go[std::size_t(l)] || !(ratios[l] > 1)) continue;
    const int hex = model.limits[std::size_t(l)].hex;
    const double stretch =
        stretch_from_density(at_end.young[hex], limits[l] / model.shapes[model.hex_shape[hex]].volume);
    const double left = std::max(1.0, std::sqrt(ratios[l]) - recovery_speed * h / stretch);
    limits[l] *= left * left;
  }
  return limits;
}

bool are_limits_recovering(const Model& model, const SolverOptions& solver, const State& state) {
  const std::vector<char> let_go = limits_let_go(model, state.time);
  if (!state.been_feasible || !any(let_go)) return false;
  const VectorXd ratios = limit_ratios(model, solver, materials_at(model, state.time), state.positions);
  for (Eigen::Index l = 0; l < ratios.size(); ++l)
    if (let_go[std::size_t(l)] && ratios[l] > 1 + solver.tolerance) return true;
  return false;
}

}  // namespace umax
