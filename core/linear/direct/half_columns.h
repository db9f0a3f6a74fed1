// Columns z = L^-1 b of a Cholesky factor's sparse right-hand sides b, so that z_i . z_j = b_i . A^-1 b_j: what forces at a few
// points of a body do to each other.
//
// A right-hand side that is zero but at a few unknowns reaches only what the elimination tree has above them (Gilbert and
// Peierls 1988, Sparse partial pivoting in time proportional to arithmetic operations). The factor's columns come in
// groups with the same rows (supernodes); each group holds the columns z that reach it, and no others.
#pragma once

#include <vector>

#include "core/base/types.h"

namespace umax {

/// A supernodal factor as CHOLMOD stores it: of group s the columns starts[s] .. starts[s + 1], its rows (diagonal ones
/// first) from row_starts[s] on, values by columns from value_starts[s] on. Memory of the factor's owner.
struct SupernodalView {
  int num_groups = 0;
  const int *starts = nullptr, *row_starts = nullptr, *value_starts = nullptr, *rows = nullptr;
  const double* values = nullptr;
};

/// One number of a sparse right-hand side, where the factor's order has its unknown.
struct SparseEntry {
  int row = 0, column = 0;
  double value = 0;
};

struct HalfColumns {
  struct Group {
    std::vector<int> columns;  // that reach it, ascending
    MatrixXd values;           // its rows of these
  };
  std::vector<Group> groups;  // of the factor's
  Eigen::Index count = 0;     // of columns
};

/// L^-1 b for `count` columns; entries at the same place add up. Reads the factor alone: safe on several threads.
HalfColumns half_solve(const SupernodalView& factor, const std::vector<SparseEntry>& entries, Eigen::Index count);

/// z_i . z_j for the columns of two: #a x #b.
MatrixXd products(const HalfColumns& a, const HalfColumns& b);

/// The same of one with itself, at half the cost.
MatrixXd products(const HalfColumns& a);

/// z_i . y for a y = L^-1 b that is full: #z. factor: what half_solve() was given.
VectorXd products(const SupernodalView& factor, const HalfColumns& half, const Eigen::Ref<const VectorXd>& y);

/// y += sum_i f_i z_i, for one number a column.
void add_columns(const SupernodalView& factor, const HalfColumns& half, const Eigen::Ref<const VectorXd>& f,
                 Eigen::Ref<VectorXd> y);

}  // namespace umax
