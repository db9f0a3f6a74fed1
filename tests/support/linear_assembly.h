// A second, simple way to assemble and solve small lattices, to hold against the program's own.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "core/element/hexahedron.h"
#include "core/model/lattice.h"

namespace umax::test {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Degrees of freedom left when some nodes are held; 3 a node, in the nodes' order.
struct FreeDofs {
  std::vector<int> index;  // of each of the 3 N degrees of freedom; -1: held
  int count = 0;
};

template <class IsHeld>
FreeDofs free_dofs(const Lattice& lattice, const IsHeld& is_held) {
  FreeDofs free;
  for (Eigen::Index n = 0; n < lattice.num_nodes(); ++n) {
    const bool held = is_held(Vector3d(lattice.rest_positions.row(n)));
    for (int axis = 0; axis < 3; ++axis) free.index.push_back(held ? -1 : free.count++);
  }
  return free;
}

inline Matrix8x3d nodes_of(const Lattice& lattice, const Points& positions, Eigen::Index hex) {
  Matrix8x3d nodes;
  for (int j = 0; j < 8; ++j) nodes.row(j) = positions.row(lattice.hexes(hex, j));
  return nodes;
}

/// Sum of element_matrix(hex) (24 x 24) over the hexes; rows of free, columns of all degrees of freedom.
template <class ElementMatrix>
SparseMatrix assemble(const Lattice& lattice, const FreeDofs& free, const ElementMatrix& element_matrix) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Matrix24d K = element_matrix(e);
    for (int a = 0; a < 24; ++a)
      for (int b = 0; b < 24; ++b) {
        const int row = free.index[3 * lattice.hexes(e, a / 3) + a % 3];
        if (row >= 0) entries.emplace_back(row, 3 * lattice.hexes(e, b / 3) + b % 3, K(a, b));
      }
  }
  SparseMatrix matrix(free.count, 3 * lattice.num_nodes());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The columns of the free degrees of freedom.
inline SparseMatrix free_columns(const SparseMatrix& rows, const FreeDofs& free) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int column = 0; column < rows.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(rows, column); it; ++it)
      if (free.index[column] >= 0) entries.emplace_back(int(it.row()), free.index[column], it.value());
  SparseMatrix matrix(free.count, free.count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Sum of element_vector(hex) over the hexes, all degrees of freedom.
template <class ElementVector>
VectorXd assemble_vector(const Lattice& lattice, const ElementVector& element_vector) {
  VectorXd sum = VectorXd::Zero(3 * lattice.num_nodes());
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Vector24d v = element_vector(e);
    for (int a = 0; a < 24; ++a) sum[3 * lattice.hexes(e, a / 3) + a % 3] += v[a];
  }
  return sum;
}

inline VectorXd restrict_to_free(const VectorXd& all, const FreeDofs& free) {
  VectorXd restricted(free.count);
  for (Eigen::Index i = 0; i < all.size(); ++i)
    if (free.index[i] >= 0) restricted[free.index[i]] = all[i];
  return restricted;
}

inline VectorXd extend_by_zero(const VectorXd& restricted, const FreeDofs& free) {
  VectorXd all = VectorXd::Zero(Eigen::Index(free.index.size()));
  for (Eigen::Index i = 0; i < all.size(); ++i)
    if (free.index[i] >= 0) all[i] = restricted[free.index[i]];
  return all;
}

}  // namespace umax::test
