// Equations of [PPO13] as they are printed, mistakes and all: what corrections() holds core's laws against.
//
// Eq. 6    G(s) = sum_n x_n dN_n/ds (X_n dN_n/ds)^-1                                the inverse of every term
// Eq. 9    K_e  = sum_q w_q B^T E B det F,   B = (diag(dN_1/ds) ... diag(dN_8/ds))   3 x 24, of H = dN/ds
// Eq. 11   du   = R^T G - I
// Eq. 13   U_e  = sum_q w_q e(du) det F
// Eq. 15   dC/dx_j = -det F / U_max sum_q w_q de/dx_j
// Eq. 16   e    = sum_i u_ii (alpha_i u_11 + beta_i u_22 + gamma_i u_33) + sum_{i<k} 1/2 E3 (u_ik + u_ki)^2
// Eq. 17   de_i/dx_j  = delta h_ji r_i + u_ii (delta_1 delta_2 delta_3)
//          de_ik/dx_j = E2 (u_ik + u_ki)(h_jk r_i + h_ji r_k)                        h of H
// Eq. 18   delta   = alpha_i u_11 + beta_i u_22 + gamma_i u_33
//          delta_k = alpha_i r_1k h_j1 + beta_i r_2k h_j2 + gamma_i r_3k h_j3
//
// r_k: k-th row of R^T;  alpha_i, beta_i, gamma_i: row i of the normal block of E, E1 on the diagonal and E2 beside it
#pragma once

#include "core/element/hexahedron.h"
#include "core/element/material.h"

namespace umax::printed {

enum class Derivatives { natural, material };  // h of H (printed) or of H F^-1 (right)
enum class ShearModulus { E2, E3 };            // of Eq. 17's second line: E2 (printed) or E3 (right)

/// [PPO13] Eq. 6 at local coordinates s. X: 8 x 3 [m] at rest, x: now. Every X_n dN_n/ds has rank one and no inverse:
/// the Moore-Penrose inverse stands for it.
Matrix3d equation_6(const Matrix8x3d& X, const Matrix8x3d& x, const Vector3d& s);

/// How near [-] the best of Eq. 6's eight matrices is to having an inverse: smallest over largest singular value.
double equation_6_reciprocal_condition(const Matrix8x3d& X, const Vector3d& s);

/// [PPO13] Eq. 9 [m] for unit Young's modulus: B has a row for each of e_11, e_22, e_33 only.
Matrix24d equation_9(const HexShape& shape, Derivatives derivatives);

/// Eq. 9 [m] for unit Young's modulus with all six rows but still of H. shape: a box.
Matrix24d equation_9_with_shear(const HexShape& shape);

/// [PPO13] Eq. 16 [J/m^3].
double equation_16(const Moduli& moduli, const Matrix3d& du);

/// [PPO13] Eq. 13 [J] of Eq. 16 for the rotation R and positions x (8 x 3 [m]).
double equation_13(const HexShape& shape, const Moduli& moduli, const Matrix3d& R, const Matrix8x3d& x);

/// [N] the sum in Eq. 15 over Eq. 17 and 18: dU/dx with R held.
Vector24d equation_17(const HexShape& shape, const Moduli& moduli, const Matrix3d& R, const Matrix8x3d& x,
                      ShearModulus shear, Derivatives derivatives);

/// [PPO13] Eq. 15 [1/m] for the limit U_max [J], given that sum.
Vector24d equation_15(const Vector24d& sum, double limit);

}  // namespace umax::printed
