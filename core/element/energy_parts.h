// Parts of a hex's energy that limits may bound, each a quadratic form Y/2 u^T K' u in the co-rotated displacement.
//
// whole        1/2 eps:E:eps
// volumetric   1/2 K tr^2 eps,       K  = Y / (3 (1 - 2 v))
// deviatoric   mu dev eps:dev eps,   mu = Y / (2 (1 + v))       volumetric + deviatoric = whole
// fibre        1/2 Y (f.eps f)^2     what the stretch along f alone would cost
//
// mean         the part integrated over the hex by the stiffness's quadrature
// peak         V times its density at one quadrature point: the form of a constraint on the largest of the eight
//
// eps: strain [-];  E: elasticity matrix [Pa];  Y: Young's modulus [Pa];  v: Poisson's ratio [-]
// f: the fibre's unit direction in the rest shape [-];  V: the hex's rest volume [m^3];  densities: [J/m^3]
// All forms turn with the hex: u is taken in its own frame, so that the derivatives of core/element/elastic_energy.h
// serve them.
#pragma once

#include "core/element/hexahedron.h"

namespace umax {

enum class EnergyPart { whole, volumetric, deviatoric, fibre };
inline constexpr int num_energy_parts = 4;

/// "limit", "limit.volumetric", ...: the scene's name of a limit on the part.
const char* limit_name(EnergyPart part);

/// Share of the density 1/2 Y s^2 of a uniaxial strain s (free sides) that the part has; the fibre lies along it.
/// 1, (1 - 2v)/3, 2 (1 + v)/3, 1.
double uniaxial_share(EnergyPart part, double poisson);

/// Strains that fill a limit on a part, each by itself; infinity: of this kind the part knows nothing.
struct LimitEquivalents {
  double stretch = 0;        // [-] uniaxial, free sides, along the fibre
  double shear = 0;          // [-] engineering shear of a symmetric pure shear, in any plane; infinity: fibre, too
  double volume_change = 0;  // [-] tr eps of a pure dilation
};

/// density: of the limit [J/m^3].
LimitEquivalents equivalents(EnergyPart part, double density, double young, double poisson);

/// K' of the part integrated over the hex, for unit Young's modulus [m]. fibre: unit vector, read by that part only.
Matrix24d part_stiffness(const HexShape& shape, EnergyPart part, const Vector3d& fibre);

/// K' of the part's density at quadrature point 0 ... 7, times the hex's volume.
Matrix24d part_stiffness_at(const HexShape& shape, EnergyPart part, const Vector3d& fibre, int point);

}  // namespace umax
