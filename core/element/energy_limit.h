// Energy limit: the constraint that bounds an element's elastic energy, and its derivative.
//
// [PPO13] Eq. 14   C_e(x)     = 1 - U_e(x) / U_max  >= 0
// [PPO13] Eq. 15   dC_e/dx_j  = -1/U_max  dU_e/dx_j
//
// x: 8 x 3 node positions [m];  U_e: element elastic energy [J];  U_max: its limit [J];  C_e: [-]
// Corrections: Eq. 16 counts the normal part twice (sigma:eps) and the shear part once (1/2 sigma:eps); the true energy
// is 1/2 sigma:eps. Both are offered. Eq. 17 prints E2 where E3 belongs and H where H F^-1 belongs.
// Deviation: the paper holds R fixed; LimitJacobian::exact lets it move.
#pragma once

#include "core/element/elastic_energy.h"

namespace umax {

enum class EnergyMeasure { true_energy, paper };             // solver.energy: which energy the limit measures
enum class LimitJacobian { exact, fixed_rotation, warped };  // solver.jacobian

/// The stiffness matrix (unit Young's modulus) whose quadratic form the measure is.
const Matrix24d& measured_stiffness(const HexShape& shape, EnergyMeasure measure);

/// C_e; 1 at rest, 0 on the limit, negative beyond.
double energy_limit_value(const HexShape& shape, EnergyMeasure measure, double young, double limit,
                          const CorotatedHex& hex);

/// dC_e/dx [1/m]. exact: of the measure with the moving rotation; fixed_rotation: of the measure with R held;
/// warped: the (true) warped elastic force over the limit, whatever the measure.
Vector24d energy_limit_jacobian(const HexShape& shape, EnergyMeasure measure, LimitJacobian jacobian,
                                RotationEstimate estimate, double young, double limit, const CorotatedHex& hex);

}  // namespace umax
