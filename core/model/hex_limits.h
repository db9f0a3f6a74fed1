// All energy limits of a model as one list of constraints: which hex, which part of its energy, how much.
#pragma once

#include "core/element/energy_limit.h"
#include "core/model/model.h"

namespace umax {

/// Adds the limits of a body's hexes, from first_hex on, whose shapes are in the model already.
void append_limits(const Body& body, Eigen::Index first_hex, Model& model);

/// Throws Error (bad_data) where solver.energy is the paper's and a body limits a part or a peak: these are of the true
/// energy only. It names the body.
void require_measurable(const Model& model, EnergyMeasure measure);

/// Does the limit bound what elasticity has as its energy, and not a part of it or another measure?
inline bool bounds_elastic_energy(const HexLimit& limit, EnergyMeasure measure) {
  return limit.form < 0 && measure == EnergyMeasure::true_energy;
}

/// U [J] that the limit bounds, and its C = 1 - U/U_max [-].
double limited_energy(const Model& model, EnergyMeasure measure, const HexLimit& limit, double young,
                      const CorotatedHex& hex);
double limit_value(const Model& model, EnergyMeasure measure, const HexLimit& limit, double young, double max_energy,
                   const CorotatedHex& hex);

/// dU/dx [N] of that energy. LimitJacobian::warped of a part or a peak is its own warped force.
Vector24d limited_gradient(const Model& model, EnergyMeasure measure, LimitJacobian jacobian, RotationEstimate estimate,
                           const HexLimit& limit, double young, const CorotatedHex& hex);

/// The largest of the limits' numbers [#L] on each hex; 0 where there is none: #E.
VectorXd largest_by_hex(const Model& model, const VectorXd& of_limits);

/// Number of hexes with a limit whose number [#L] is positive.
int count_hexes(const Model& model, const VectorXd& of_limits);

}  // namespace umax
