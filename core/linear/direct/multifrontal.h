// The numeric part of the direct solver's factorisation, by the multifrontal method (Duff and Reid 1983; Liu 1992, The
// multifrontal method for sparse matrix solution: theory and practice).
//
// The factor's columns stand in groups with the same rows (supernodes), and each group waits for those that the elimination
// tree has below it. A group's front is the dense matrix of its rows: what the matrix has in the group's columns, plus what
// is left of the fronts below. The group's columns are eliminated in it, and what is left of it goes to the front above.
// Subtrees are independent, and go to the threads that are free; each front adds what it gets in one order.
#pragma once

#include <vector>

#include "core/linear/direct/half_columns.h"
#include "core/linear/direct/system_matrix.h"

namespace umax {

/// Rows that follow each other in a front and in the one above.
struct RowRun {
  int from = 0, to = 0, count = 0;  // first row in the front, first row above
};

/// How the groups of a factor hang together; made once for a pattern.
struct FrontTree {
  std::vector<int> parents;                   // of each group, -1: none
  std::vector<std::vector<int>> children;     // ascending
  std::vector<std::vector<RowRun>> runs;      // of a group's rows below its columns
  std::vector<std::vector<int>> matrix_rows;  // of the matrix's numbers in a group's columns: their rows in its front
  std::vector<double> work;                   // [operations] of the group and all below it
};

/// pattern: the groups of the factor (its values are not read); matrix: any one with this pattern.
FrontTree make_front_tree(const SupernodalView& pattern, const SystemMatrix& matrix);

/// Writes L to values, where the pattern says. False if the matrix is not positive definite; values are all 0 then.
/// The same bits for any number of threads.
bool factorize(const FrontTree& tree, const SupernodalView& pattern, const SystemMatrix& matrix, double* values);

}  // namespace umax
