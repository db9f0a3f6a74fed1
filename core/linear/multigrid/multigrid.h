// Geometric multigrid for the matrix-free operator: an approximate inverse of A that is symmetric and positive
// definite, for use as a preconditioner (Briggs, Henson, McCormick, A Multigrid Tutorial, 2nd edition, 2000).
//
// A V-cycle. Coarse matrices are those of cells `factor` times larger (s: mean over the fine cells, 0 where there is
// none; R: polar factor of sum s R; w: P^T w); a coarse node is fixed if the fine one at its place is. Smoother:
// Chebyshev polynomials in D^-1 A (Adams, Brezina, Hu, Tuminaro 2003), D = 3 x 3 diagonal blocks, on
// [lambda / 8, lambda] with lambda the largest eigenvalue of D^-1 K of one cell, a bound for the whole. Flat cells are
// first coarsened along their short edges only. The last level is factored (core/linear/multigrid/envelope_cholesky.h).
// Single stiff hexes are solved for before and after (stiff_cell_smoother.h).
#pragma once

#include <vector>

#include "core/linear/multigrid/envelope_cholesky.h"
#include "core/linear/multigrid/multigrid_level.h"
#include "core/linear/multigrid/stiff_cell_smoother.h"

namespace umax {

struct MultigridOptions {
  int degree = 2;               // of the smoothing polynomials; more: fewer, dearer iterations
  double local_contrast = 100;  // [-] of a hex with its neighbours from which it is solved for by itself
  InstructionSet instruction_set = best_instruction_set();
};

struct Multigrid {
  std::vector<MultigridLevel> levels;  // finest first; fill levels[0].matrix, then set_up()
  std::vector<int> dense_slots;        // nodes of the last level
  bool has_dense = false;              // false: the last level is smoothed only (islands that no coarsening joins)
  EnvelopeCholesky dense;
  double local_contrast = 0;
  StiffCellSmoother stiff_cell_smoother;  // of the finest level
  AlignedArray<float> corrected, rest;    // iterate and residual around the V-cycle, where there are stiff cells
};

/// Topology and memory for a lattice, whose cells have all the same Poisson's ratio.
Multigrid make_multigrid(BrickLattice lattice, double poisson, const MultigridOptions& options = {});

/// Everything that follows from levels[0].matrix. Values as small as 1 / 1000 of each other are fine.
void set_up(Multigrid& multigrid);

/// The same in parts: the levels; then, beside what needs these alone, the factor of the last one, if it has one; and the
/// single stiff hexes, which precondition() alone sees.
void set_up_levels(Multigrid& multigrid);
void factorize_last(Multigrid& multigrid);
void set_up_stiff_cells(Multigrid& multigrid);

/// z ~ A^-1 r, kept until the next call; `product` becomes r . z.
const AlignedArray<float>& precondition(Multigrid& multigrid, const AlignedArray<float>& r, double& product);

}  // namespace umax
