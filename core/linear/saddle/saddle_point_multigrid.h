// Multigrid for a matrix with rank-one terms, in the form of a saddle point: one cycle is the preconditioner of
// core/linear/saddle/saddle_point.h.
//
//   [ A    G ] [x]   [b]
//   [ G^T -I ] [y] = [q]
// However stiff the terms are, a cycle reduces the error by about the same share, on any number of hexes.
//
// Smoother (Braess and Sarazin 1997): a step of damped Jacobi, then the multipliers that bring it back to the terms,
//   s = x + w D^-1 (b - A x - G y),  S dy = G^T s - q - y,  x = s - w D^-1 G dy,   S = I + w G^T D^-1 G
// S couples hexes that share a node (core/linear/saddle/limit_schur_complement.h). A coarse cell has as many terms as
// the richest of the cells it covers: its i-th is P^T times the sum of their i-th ones, as multipliers are the same in
// all of them. Terms that are alike by their meaning, as springs along normals are, come in groups instead: all of a group in
// the cells it covers become one, as pressures of contacts beside each other are the same and have nothing to do with a
// limit's multiplier.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "core/linear/multigrid/multigrid.h"
#include "core/linear/saddle/limit_schur_complement.h"
#include "core/linear/saddle/rank_one_terms.h"

namespace umax {

struct SaddlePointLevel {
  RankOneTerms terms;
  VectorXf own;              // the diagonal that stands for -I: how many terms of the finest level each one is
  std::vector<int> parents;  // of each term, on the next level
  LimitSchurComplement complement;
};

struct SaddlePointMultigrid {
  std::vector<SaddlePointLevel> levels;    // as the multigrid's
  MatrixXd half_responses;                 // of the last level, if it is factored as L L^T: L^-1 G,
  Eigen::LLT<MatrixXd> dense{MatrixXd()};  // and C + G^T A^-1 G
  bool has_dense = false;
  AlignedArray<float> rest;  // of the first level: b - G y
  double weight = 1;         // [N/m] what makes squared residuals of terms comparable with those of nodes
};

/// For a multigrid whose levels are set up: factors the last one beside what the terms need of the others.
void set_up(Multigrid& multigrid, RankOneTerms terms, SaddlePointMultigrid& coupled);

/// (z, y) ~ (x, y) for the right-hand side (r, q). Returns z, kept until the next call.
const AlignedArray<float>& precondition(Multigrid& multigrid, SaddlePointMultigrid& coupled,
                                        const AlignedArray<float>& r, const VectorXd& q, VectorXd& y);

}  // namespace umax
