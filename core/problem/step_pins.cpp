#include "core/problem/step_pins.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr double exact = 1e6;  // [-] of the stiffness of a hex with its inertia

double stiffness_of_hex(const Model& model, const VectorXd& young, double time_step, int hex) {
  double mass = 0;
  for (int n = 0; n < 8; ++n) mass += model.node_mass[model.hexes(hex, n)] / 8;
  return young[hex] * body_of(model, hex).cell_size + mass / (time_step * time_step);
}

void add_pulls(const Model& model, const std::vector<Pull>& pulls, std::vector<PinSpring>& springs) {
  for (const Pull& pull : pulls)
    for (const Model::BodyRange& body : model.bodies)
      if (body.name == pull.body)
        springs.push_back({body.first_hex + pull.hex, pull.weights, pull.stiffness, pull.place, false});
  std::stable_sort(springs.begin(), springs.end(),
                   [](const PinSpring& a, const PinSpring& b) { return a.hex < b.hex; });
}

}  // namespace

Vector3d missed(const Model& model, const PinSpring& spring, const Points& positions) {
  return hex_nodes(model, positions, spring.hex).transpose() * spring.weights - spring.place;
}

StepPins pins_at(const Model& model, const std::vector<Pull>& pulls, const VectorXd& young, double time,
                 double time_step) {
  StepPins pins;
  std::vector<Points> places;
  Eigen::Index count = 0;
  for (const Model::BodyRange& body : model.bodies) {
    if (!body.pins) continue;
    PinDemands demands = body.pins->demands_at(time);
    for (const int node : demands.nodes) pins.nodes.push_back(body.first_node + node);
    count += demands.places.rows();
    places.push_back(std::move(demands.places));
    for (PinSpring& spring : demands.springs) {
      spring.hex += body.first_hex;
      if (spring.is_exact) spring.stiffness = exact * stiffness_of_hex(model, young, time_step, spring.hex);
      pins.springs.push_back(spring);
    }
  }
  if (!pulls.empty()) add_pulls(model, pulls, pins.springs);
  pins.places.resize(count, 3);
  count = 0;
  for (const Points& of_body : places) {
    pins.places.middleRows(count, of_body.rows()) = of_body;
    count += of_body.rows();
  }
  if (pins.springs.empty()) return pins;
  pins.starts.assign(std::size_t(model.num_hexes()) + 1, 0);
  for (const PinSpring& spring : pins.springs) ++pins.starts[std::size_t(spring.hex) + 1];
  for (std::size_t e = 1; e < pins.starts.size(); ++e) pins.starts[e] += pins.starts[e - 1];
  return pins;
}

void place_driven(const StepPins& pins, Points& positions) {
  for (std::size_t i = 0; i < pins.nodes.size(); ++i) positions.row(pins.nodes[i]) = pins.places.row(Eigen::Index(i));
}

double spring_energy(const Model& model, const StepPins& pins, const Points& positions) {
  double sum = 0;
  for (const PinSpring& spring : pins.springs)
    sum += 0.5 * spring.stiffness * missed(model, spring, positions).squaredNorm();
  return sum;
}

void add_spring_gradient(const Model& model, const StepPins& pins, const Points& positions, VectorXd& gradient) {
  for (const PinSpring& spring : pins.springs) {
    const Vector3d force = spring.stiffness * missed(model, spring, positions);
    for (int n = 0; n < 8; ++n) gradient.segment<3>(3 * model.hexes(spring.hex, n)) += spring.weights[n] * force;
  }
}

void add_spring_hessian(const StepPins& pins, Eigen::Index hex, Matrix24d& element) {
  if (pins.starts.empty()) return;
  for (int i = pins.starts[std::size_t(hex)]; i < pins.starts[std::size_t(hex) + 1]; ++i) {
    const PinSpring& spring = pins.springs[std::size_t(i)];
    for (int m = 0; m < 8; ++m)
      for (int n = 0; n < 8; ++n)
        element.block<3, 3>(3 * m, 3 * n).diagonal().array() +=
            spring.stiffness * spring.weights[m] * spring.weights[n];
  }
}

double farthest_drive(const Model& model, const State& state, double time_step) {
  double farthest = 0;
  for (const Model::BodyRange& body : model.bodies) {
    if (!body.pins) continue;
    const PinDemands demands = body.pins->demands_at(state.time + time_step);
    for (std::size_t i = 0; i < demands.nodes.size(); ++i) {
      const int node = body.first_node + demands.nodes[i];
      const Eigen::RowVector3d expected = state.positions.row(node) + time_step * state.velocities.row(node);
      farthest = std::max(farthest, (demands.places.row(Eigen::Index(i)) - expected).norm() / body.cell_size);
    }
  }
  return farthest;
}

}  // namespace umax
