#include "core/system_matrix.h"

#include <algorithm>

#include "core/parallel.h"

namespace umax {
namespace {

// nodes that share a hex with node a and come after it, ascending, a itself first
std::vector<std::vector<int>> later_neighbours(const Model& model) {
  std::vector<std::vector<int>> neighbours(model.num_nodes());
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    for (int m = 0; m < 8; ++m)
      for (int n = 0; n < 8; ++n)
        if (model.hexes(e, n) >= model.hexes(e, m)) neighbours[model.hexes(e, m)].push_back(model.hexes(e, n));
  for (std::vector<int>& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

}  // namespace

SystemMatrix make_system_matrix(const Model& model) {
  SystemMatrix matrix;
  matrix.hexes = model.hexes;
  matrix.node_fixed = model.node_fixed;
  const std::vector<std::vector<int>> neighbours = later_neighbours(model);
  matrix.column_starts.push_back(0);
  for (Eigen::Index a = 0; a < model.num_nodes(); ++a)
    for (int c = 0; c < 3; ++c) {
      for (const int b : neighbours[a])
        for (int r = (b == a ? c : 0); r < 3; ++r) matrix.row_indices.push_back(3 * b + r);
      matrix.column_starts.push_back(int(matrix.row_indices.size()));
    }
  matrix.values = VectorXd::Zero(Eigen::Index(matrix.row_indices.size()));

  matrix.block_slots.resize(model.num_hexes());
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    int pair = 0;
    for (int m = 0; m < 8; ++m)
      for (int n = m; n < 8; ++n) {
        const auto [a, b] = std::minmax(model.hexes(e, m), model.hexes(e, n));
        const std::vector<int>& list = neighbours[a];
        matrix.block_slots[e][pair++] = std::uint8_t(std::lower_bound(list.begin(), list.end(), b) - list.begin());
      }
  }
  return matrix;
}

void reset(SystemMatrix& matrix) {
  matrix.values.setZero();
  for (std::size_t node = 0; node < matrix.node_fixed.size(); ++node)
    if (matrix.node_fixed[node])
      for (int c = 0; c < 3; ++c) matrix.values[matrix.column_starts[3 * node + c]] = 1;
}

void add_mass(const VectorXd& node_mass, double coefficient, SystemMatrix& matrix) {
  for (Eigen::Index node = 0; node < node_mass.size(); ++node)
    if (!matrix.node_fixed[node])
      for (int c = 0; c < 3; ++c) matrix.values[matrix.column_starts[3 * node + c]] += coefficient * node_mass[node];
}

void add_element(Eigen::Index hex, const Matrix24d& element, SystemMatrix& matrix) {
  int pair = -1;
  for (int m = 0; m < 8; ++m)
    for (int n = m; n < 8; ++n) {
      const int slot = matrix.block_slots[hex][++pair];
      int column_node = m, row_node = n;
      if (matrix.hexes(hex, m) > matrix.hexes(hex, n)) std::swap(column_node, row_node);
      const int a = matrix.hexes(hex, column_node), b = matrix.hexes(hex, row_node);
      if (matrix.node_fixed[a] || matrix.node_fixed[b]) continue;
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

VectorXd multiply(const SystemMatrix& matrix, const VectorXd& x) {
  VectorXd y = VectorXd::Zero(x.size());
  for (int column = 0; column < matrix.num_unknowns(); ++column)
    for (int k = matrix.column_starts[column]; k < matrix.column_starts[column + 1]; ++k) {
      const int row = matrix.row_indices[k];
      y[row] += matrix.values[k] * x[column];
      if (row != column) y[column] += matrix.values[k] * x[row];
    }
  return y;
}

}  // namespace umax
