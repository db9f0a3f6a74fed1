// The assembled matrix of a step, for the direct solver: symmetric, 3 x 3 blocks between nodes that share a hex, lower
// triangle, compressed columns. Its rows and columns stand in elimination order, 3 rank + axis; vectors outside of it
// are by node, 3 node + axis. Fixed nodes keep their rows as identity, so that the pattern never changes.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/model/model.h"

namespace umax {

struct SystemMatrix {
  std::vector<int> column_starts;  // 3 #N + 1
  std::vector<int> row_indices;    // ascending in each column, first is the diagonal
  VectorXd values;
  std::vector<int> order, ranks;  // node at each rank, rank of each node
  std::vector<int> last;          // nodes (ascending) after which only such nodes are eliminated
  Hexes hexes;                    // #E x 8 ranks
  std::vector<char> fixed;        // by rank
  std::vector<std::array<std::uint8_t, 36>>
      block_slots;  // per hex and local node pair: position in the column's block list

  int num_unknowns() const { return int(column_starts.size()) - 1; }
};

/// For each of num_nodes nodes: itself and the nodes after it with which it shares a hex, ascending.
std::vector<std::vector<int>> later_neighbours(const Hexes& hexes, Eigen::Index num_nodes);

/// Pattern of hexes (#E x 8 nodes) in elimination_order(hexes, #N, last), values zero. fixed: #N.
SystemMatrix make_system_matrix(const Hexes& hexes, const std::vector<char>& fixed, const std::vector<int>& last);

/// Of all bodies in one matrix.
SystemMatrix make_system_matrix(const Model& model, const std::vector<int>& last = {});

/// Of one body, whose nodes and hexes count from 0 on.
SystemMatrix make_body_matrix(const Model& model, const Model::BodyRange& body, const std::vector<int>& last = {});

/// All values to zero, ones on the diagonal of fixed nodes.
void reset(SystemMatrix& matrix);

/// Adds diag(coefficient * node_mass), not on fixed nodes.
void add_mass(const VectorXd& node_mass, double coefficient, SystemMatrix& matrix);

/// Adds a symmetric element matrix (its lower triangle by global order is used).
void add_element(Eigen::Index hex, const Matrix24d& element, SystemMatrix& matrix);

/// Adds every hex's matrix: fill(hex, element) is called in parallel, the sums are in the order of the hexes.
void add_elements(SystemMatrix& matrix, const std::function<void(Eigen::Index, Matrix24d&)>& fill);

}  // namespace umax
