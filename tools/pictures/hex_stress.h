// The elastic energy and the stress of each hex, as they are now.
//
// sigma = R (lambda tr(eps) I + 2 mu eps) R^T,   eps = 1/V sum_q w_q sym(sum_j u_j g_qj^T)
//
// sigma: Cauchy stress of the co-rotational material, the hex's mean, along world axes [Pa];  R: the hex's rotation
// eps: mean strain in the hex's own frame [-];  u_j: displacement of node j there [m];  g_qj: gradient of the node's
// shape function at quadrature point q [1/m];  w_q: its share of the volume V [m^3];  lambda, mu: moduli [Pa]
#pragma once

#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

struct HexStress {
  VectorXd energy;               // #E [J] true elastic energy
  std::vector<Matrix3d> stress;  // #E [Pa]
};
HexStress hex_stress(const Simulation& simulation, const State& state);

/// [Pa] the uniaxial stress that distorts as much.
double von_mises(const Matrix3d& stress);

}  // namespace umax
