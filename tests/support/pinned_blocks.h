// Pins and the blocks that they hold, for tests.
#pragma once

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/model/pins.h"
#include "tests/support/bodies.h"
#include "tests/support/hex_samples.h"

namespace umax::test {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Points of a box lattice as a pin that does not move yet
inline Pin pin_at(const Lattice& lattice, const Vector3i& num_cells, const std::vector<Vector3d>& places,
                  double stiffness = infinity) {
  Pin pin;
  pin.name = "pin";
  pin.rest = as_points(places);
  pin.points = embed_in_box(lattice, num_cells, pin.rest);
  pin.part = VectorXi::Zero(pin.rest.rows());
  pin.stiffness = VectorXd::Constant(pin.rest.rows(), stiffness);
  pin.motion.pivot = pin.rest.colwise().mean().transpose();
  return pin;
}

inline void hold(std::vector<Pin> pins, Body& body) {
  body.pins = std::make_shared<const BodyPins>(std::move(pins), body.lattice.rest_positions, body.lattice.hexes);
}

/// The farthest of the pin's points from where they should be [m].
inline double miss(const Pin& pin, const Model& model, const State& state) {
  const Points targets = targets_at(pin, state.time);
  double farthest = 0;
  for (Eigen::Index p = 0; p < targets.rows(); ++p) {
    Vector3d place = Vector3d::Zero();
    for (int n = 0; n < 8; ++n)
      place += pin.points.weights(p, n) * state.positions.row(model.hexes(pin.points.hex[p], n)).transpose();
    farthest = std::max(farthest, (place - targets.row(p).transpose()).norm());
  }
  return farthest;
}

inline Body soft_block(const Vector3i& cells) {
  Body body = make_block(cells, {0, 0, 0}, 0.1, 2);
  body.material.young = 100e3;
  return body;
}

}  // namespace umax::test
