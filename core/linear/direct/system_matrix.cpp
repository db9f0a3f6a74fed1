#include "core/linear/direct/system_matrix.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/linear/direct/sparse_cholesky.h"

namespace umax {
std::vector<std::vector<int>> later_neighbours(const Hexes& hexes, Eigen::Index num_nodes) {
  std::vector<std::vector<int>> neighbours(num_nodes);
  for (Eigen::Index e = 0; e < hexes.rows(); ++e)
    for (int m = 0; m < 8; ++m)
      for (int n = 0; n < 8; ++n)
        if (hexes(e, n) >= hexes(e, m)) neighbours[hexes(e, m)].push_back(hexes(e, n));
  for (std::vector<int>& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

SystemMatrix make_system_matrix(const Model& model, const std::vector<int>& last) {
  return make_system_matrix(model.hexes, model.node_fixed, last);
}

SystemMatrix make_body_matrix(const Model& model, const Model::BodyRange& body, const std::vector<int>& last) {
  const Hexes hexes = model.hexes.middleRows(body.first_hex, body.num_hexes).array() - body.first_node;
  const auto first = model.node_fixed.begin() + body.first_node;
  return make_system_matrix(hexes, std::vector<char>(first, first + body.num_nodes), last);
}

SystemMatrix make_system_matrix(const Hexes& hexes, const std::vector<char>& fixed, const std::vector<int>& last) {
  const auto num_nodes = Eigen::Index(fixed.size());
  SystemMatrix matrix;
  matrix.last = last;
  matrix.order = elimination_order(hexes, num_nodes, last);
  matrix.ranks.resize(matrix.order.size());
  for (std::size_t rank = 0; rank < matrix.order.size(); ++rank) {
    matrix.ranks[matrix.order[rank]] = int(rank);
    matrix.fixed.push_back(fixed[matrix.order[rank]]);
  }
  matrix.hexes = hexes.unaryExpr([&](int node) { return matrix.ranks[node]; });

  const std::vector<std::vector<int>> neighbours = later_neighbours(matrix.hexes, num_nodes);
  matrix.column_starts.push_back(0);
  for (Eigen::Index a = 0; a < num_nodes; ++a)
    for (int c = 0; c < 3; ++c) {
      for (const int b : neighbours[a])
        for (int r = (b == a ? c : 0); r < 3; ++r) matrix.row_indices.push_back(3 * b + r);
      matrix.column_starts.push_back(int(matrix.row_indices.size()));
    }
  matrix.values = VectorXd::Zero(Eigen::Index(matrix.row_indices.size()));

  matrix.block_slots.resize(hexes.rows());
  for (Eigen::Index e = 0; e < hexes.rows(); ++e) {
    int pair = 0;
    for (int m = 0; m < 8; ++m)
      for (int n = m; n < 8; ++n) {
        const auto [a, b] = std::minmax(matrix.hexes(e, m), matrix.hexes(e, n));
        const std::vector<int>& list = neighbours[a];
        matrix.block_slots[e][pair++] = std::uint8_t(std::lower_bound(list.begin(), list.end(), b) - list.begin());
      }
  }
  return matrix;
}

void reset(SystemMatrix& matrix) {
  matrix.values.setZero();
  for (std::size_t rank = 0; rank < matrix.fixed.size(); ++rank)
    if (matrix.fixed[rank])
      for (int c = 0; c < 3; ++c) matrix.values[matrix.column_starts[3 * rank + c]] = 1;
}

void add_mass(const VectorXd& node_mass, double coefficient, SystemMatrix& matrix) {
  for (std::size_t rank = 0; rank < matrix.fixed.size(); ++rank)
    if (!matrix.fixed[rank])
      for (int c = 0; c < 3; ++c)
        matrix.values[matrix.column_starts[3 * rank + c]] += coefficient * node_mass[matrix.order[rank]];
}

void add_element(Eigen::Index hex, const Matrix24d& element, SystemMatrix& matrix) {
  int pair = -1;
  for (int m = 0; m < 8; ++m)
    for (int n = m; n < 8; ++n) {
      const int slot = matrix.block_slots[hex][++pair];
      int column_node = m, row_node = n;
      if (matrix.hexes(hex, m) > matrix.hexes(hex, n)) std::swap(column_node, row_node);
      const int a = matrix.hexes(hex, column_node), b = matrix.hexes(hex, row_node);
      if (matrix.fixed[a] || matrix.fixed[b]) continue;
      for (int c = 0; c < 3; ++c) {
        double* column = matrix.values.data() + matrix.column_starts[3 * a + c];
        const double* source = element.data() + 24 * (3 * column_node + c) + 3 * row_node;
        if (a == b)
          for (int r = c; r < 3; ++r) column[r - c] += source[r];
        else
          for (int r = 0; r < 3; ++r) column[(3 - c) + 3 * (slot - 1) + r] += source[r];
      }
    }
}

void add_elements(SystemMatrix& matrix, const std::function<void(Eigen::Index, Matrix24d&)>& fill) {
  constexpr Eigen::Index chunk = 2048, grain = 16;  // element matrices in memory at once, and per task
  const Eigen::Index num_hexes = matrix.hexes.rows();
  std::vector<Matrix24d> elements(std::min(chunk, num_hexes));
  for (Eigen::Index first = 0; first < num_hexes; first += chunk) {
    const Eigen::Index count = std::min(chunk, num_hexes - first);
    parallel_blocks(count, grain, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) fill(first + i, elements[i]);
    });
    for (Eigen::Index i = 0; i < count; ++i) add_element(first + i, elements[i], matrix);
  }
}

}  // namespace umax
