// Linear isotropic elasticity: moduli, and how a limit given as stretch, density or energy becomes another.
//
// [PPO13] Sect. 4.2   E1      = Y (1 - v) / ((1 + v)(1 - 2 v))
//                     E2      = Y v / ((1 + v)(1 - 2 v))
//                     E3      = Y / (2 (1 + v))
// Uniaxial stress     density = 1/2 Y s^2,   U_max = density V
//
// Y: Young's modulus [Pa];  v: Poisson's ratio [-];  E1, E2, E3: entries of the elasticity matrix [Pa]
// s: limit as uniaxial engineering strain [-];  density: [J/m^3];  V: the hex's rest volume [m^3];  U_max: [J]
#pragma once

#include "core/base/types.h"

namespace umax {

struct Moduli {
  double E1 = 0, E2 = 0, E3 = 0;  // [Pa] lambda + 2 mu, lambda, mu
};
Moduli moduli(double young, double poisson);

/// 6 x 6 matrix E with sigma = E eps; strain order (xx, yy, zz, yz, xz, xy), ENGINEERING shear (2 eps_ik).
Matrix6d elasticity_matrix(double young, double poisson);

/// [J/m^3] of a uniaxial strain (0.2 for 20 %), and back.
double density_from_stretch(double young, double strain);
double stretch_from_density(double young, double density);

}  // namespace umax
