// Pins and pulls within one time step: where nodes that pins drive go, and springs on the others.
//
// energy     1/2 k |w.x - p|^2
// gradient   k (w.x - p) w
// hessian    k w w^T, alike for x, y and z
//
// w: weights of a hex's nodes [-];  p: where w.x should be [m];  k: stiffness [N/m]; of exact conditions a million
// times that of the hex with its inertia, so that what forces do to them is below a millionth of a cell
#pragma once

#include <vector>

#include "core/model/model.h"
#include "core/model/pins.h"
#include "core/problem/step_options.h"

namespace umax {

struct StepPins {
  std::vector<int> nodes;          // of the model, driven
  Points places;                   // of these at the end of the step [m]
  std::vector<PinSpring> springs;  // by hex of the model, ascending
  std::vector<int> starts;         // #E + 1 those of hex e: starts[e] ... starts[e + 1] - 1; empty: there are none
};

/// At a time [s], the end of a step of that size. pulls: of other bodies are passed over. young: #E [Pa].
StepPins pins_at(const Model& model, const std::vector<Pull>& pulls, const VectorXd& young, double time,
                 double time_step);

/// Puts driven nodes where they go.
void place_driven(const StepPins& pins, Points& positions);

/// By how much [m] what a spring of the model holds is away from where it should be: w.x - p.
Vector3d missed(const Model& model, const PinSpring& spring, const Points& positions);

/// What the springs hold [J], and what they push nodes with, added to a gradient of 3 #N [N].
double spring_energy(const Model& model, const StepPins& pins, const Points& positions);
void add_spring_gradient(const Model& model, const StepPins& pins, const Points& positions, VectorXd& gradient);

/// Adds the springs of a hex to its matrix.
void add_spring_hessian(const StepPins& pins, Eigen::Index hex, Matrix24d& element);

/// How far [cells] driven nodes go in a step away from where they would be by their velocity, at most.
double farthest_drive(const Model& model, const State& state, double time_step);

}  // namespace umax
