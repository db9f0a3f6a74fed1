#include "core/linear/multigrid/stiff_cell_smoother.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr int most_shared = 3;      // solved hexes that touch a hex of the lattice
constexpr double damping = 0.63;    // less than 2 / most_shared
constexpr Eigen::Index grain = 16;  // hexes per task

Vector3i neighbour_step(int n) {
  return {n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
}

// s per slot, 0 where there is no cell
std::vector<float> stiffnesses(const BrickLattice& lattice, const HexMatrix<float>& matrix) {
  std::vector<float> s(lattice.num_slots(), 0.f);
  for_each_column(lattice, [&](int first, int last) {
    for (std::size_t line = std::size_t(first) * brick_lines; line < std::size_t(last) * brick_lines; ++line)
      for (int r = 0; r < frame_components; ++r)
        for (int k = 0; k < brick_lanes; ++k) {
          const float q = matrix.frames[(line * frame_components + r) * brick_lanes + k];
          s[line * brick_lanes + k] += q * q / 3;
        }
    return 0.0;
  });
  return s;
}

bool is_stiff(const BrickLattice& lattice, const std::vector<float>& s, int slot, double contrast) {
  float softest = std::numeric_limits<float>::infinity();
  for (int n = 0; n < 27; ++n) {
    const int other = slot_near(lattice, slot, neighbour_step(n));
    if (other >= 0 && s[other] > 0) softest = std::min(softest, s[other]);
  }
  return double(s[slot]) >= contrast * double(softest);
}

// in ascending order, as long as no hex is touched by more than most_shared of them
std::vector<int> choose(const BrickLattice& lattice, const std::vector<float>& s, double contrast) {
  const float most = *std::max_element(s.begin(), s.end());
  float least = most;
  for (const float value : s)
    if (value > 0) least = std::min(least, value);
  std::vector<int> chosen;
  if (double(most) < contrast * double(least)) return chosen;

  std::vector<std::uint8_t> touched(s.size(), 0);
  for (int slot = 0; slot < int(s.size()); ++slot) {
    if (double(s[slot]) < contrast * double(least) || !is_stiff(lattice, s, slot, contrast)) continue;
    bool crowded = false;
    for (int n = 0; n < 27; ++n) {
      const int other = slot_near(lattice, slot, neighbour_step(n));
      crowded |= other >= 0 && touched[other] == most_shared;
    }
    if (crowded) continue;
    chosen.push_back(slot);
    for (int n = 0; n < 27; ++n) {
      const int other = slot_near(lattice, slot, neighbour_step(n));
      if (other >= 0) ++touched[other];
    }
  }
  return chosen;
}

// the nodes that a neighbour at `step` shares with the hex: which of the hex's 8 each of its own 8 is, or -1
std::array<int, 8> shared_nodes(const Vector3i& step) {
  std::array<int, 8> local{};
  for (int n = 0; n < 8; ++n) {
    const Vector3i at = corner(n) + step;
    local[n] = at.minCoeff() >= 0 && at.maxCoeff() <= 1 ? 4 * at[0] + 2 * at[1] + at[2] : -1;
  }
  return local;
}

// Calls visit(Q, step, local) for the hexes that touch the one in a slot, itself too: their frame, where they are, and
// which nodes they share with it.
template <class Visit>
void for_each_around(const BrickLattice& lattice, const HexMatrix<float>& matrix, int slot, const Visit& visit) {
  for (int n = 0; n < 27; ++n) {
    const int cell = slot_near(lattice, slot, neighbour_step(n));
    if (cell < 0) continue;
    const Matrix3d Q = frame_at(matrix.frames, cell);
    if (!Q.isZero(0)) visit(Q, neighbour_step(n), shared_nodes(neighbour_step(n)));
  }
}

Matrix24d local_matrix(const BrickLattice& lattice, const HexMatrix<float>& matrix, const Matrix24d& K, int slot) {
  Matrix24d A = Matrix24d::Zero();
  for_each_around(lattice, matrix, slot, [&](const Matrix3d& Q, const Vector3i&, const std::array<int, 8>& local) {
    add_turned_stiffness(Q, K, local, local, A);
  });
  return A;
}

// damping A_e^-1, zero in the rows and columns of nodes that are not free
StiffCellSmoother::Matrix24f damped_inverse(Matrix24d A, const HexMatrix<float>& matrix,
                                            const std::array<int, 8>& nodes) {
  Matrix24d free = Matrix24d::Identity();
  for (int n = 0; n < 8; ++n) {
    const double w = double(matrix.diagonal[nodes[n]]);
    for (int i = 3 * n; i < 3 * n + 3; ++i)
      if (w > 0) {
        A(i, i) += w;
      } else {
        A.row(i).setZero();
        A.col(i).setZero();
        A(i, i) = 1;
        free(i, i) = 0;
      }
  }
  const Matrix24d inverse = damping * (Eigen::LLT<Matrix24d>(A).solve(free));
  return (0.5 * (inverse + inverse.transpose())).cast<float>();
}

// A between the hex's nodes and those up to one hex away, zero in the rows of nodes that are not free
void store_rows(const BrickLattice& lattice, const HexMatrix<float>& matrix, const Matrix24d& K, int slot,
                const std::array<int, 8>& nodes, std::array<int, 64>& reached, StiffCellSmoother::Rows& rows) {
  const auto at = [](const Vector3i& step) { return 16 * (step[0] + 1) + 4 * (step[1] + 1) + step[2] + 1; };
  for (int m = 0; m < 64; ++m) reached[m] = slot_near(lattice, slot, {m / 16 - 1, m / 4 % 4 - 1, m % 4 - 1});
  Eigen::Matrix<double, 24, 192> A = Eigen::Matrix<double, 24, 192>::Zero();
  for_each_around(lattice, matrix, slot, [&](const Matrix3d& Q, const Vector3i& step, const std::array<int, 8>& local) {
    std::array<int, 8> columns{};
    for (int n = 0; n < 8; ++n) columns[n] = at(step + corner(n));
    add_turned_stiffness(Q, K, local, columns, A);
  });
  for (int n = 0; n < 8; ++n) {
    const double w = double(matrix.diagonal[nodes[n]]);
    if (w > 0)
      A.block<3, 3>(3 * n, 3 * at(corner(n))).diagonal().array() += w;
    else
      A.middleRows<3>(3 * n).setZero();
  }
  // nodes that are not free do not move
  for (int m = 0; m < 64; ++m)
    if (reached[m] < 0 || !(matrix.diagonal[reached[m]] > 0)) {
      reached[m] = -1;
      A.middleCols<3>(3 * m).setZero();
    }
  rows = A.cast<float>();
}

// the rows of A x that belong to a hex's nodes
StiffCellSmoother::Vector24f multiply(const StiffCellSmoother& cells, std::size_t e, const AlignedArray<float>& x) {
  Eigen::Matrix<float, 192, 1> around = Eigen::Matrix<float, 192, 1>::Zero();
  for (int m = 0; m < 64; ++m)
    if (const int slot = cells.reached[e][m]; slot >= 0) around.segment<3>(3 * m) = node_value(x, slot);
  return cells.rows[e] * around;
}

}  // namespace

StiffCellSmoother make_stiff_cell_smoother(const HexOperator& op, const HexMatrix<float>& matrix,
                                           const Matrix24d& stiffness, double contrast, Eigen::Index most_rows) {
  const BrickLattice& lattice = op.lattice;
  const std::vector<int> chosen = choose(lattice, stiffnesses(lattice, matrix), contrast);
  StiffCellSmoother cells;
  cells.nodes.resize(chosen.size());
  cells.inverses.resize(chosen.size());
  const bool with_rows = Eigen::Index(chosen.size()) <= most_rows;
  if (with_rows) {
    cells.reached.resize(chosen.size());
    cells.rows.resize(chosen.size());
  }
  parallel_blocks(Eigen::Index(chosen.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      cells.nodes[e] = corner_slots(lattice, chosen[e]);
      cells.inverses[e] = damped_inverse(local_matrix(lattice, matrix, stiffness, chosen[e]), matrix, cells.nodes[e]);
      if (with_rows) store_rows(lattice, matrix, stiffness, chosen[e], cells.nodes[e], cells.reached[e], cells.rows[e]);
    }
  });
  return cells;
}

void add_corrections(const StiffCellSmoother& cells, const AlignedArray<float>& r, AlignedArray<float>& z) {
  std::vector<StiffCellSmoother::Vector24f> corrections(cells.nodes.size());
  parallel_blocks(Eigen::Index(cells.nodes.size()), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e)
      corrections[e].noalias() = cells.inverses[e] * gather_nodes(cells.nodes[e], r);
  });
  // one after the other: neighbours may share nodes
  for (std::size_t e = 0; e < corrections.size(); ++e) add_at_nodes(cells.nodes[e], corrections[e], z);
}

std::vector<StiffCellSmoother::Vector24f> correct_before(const StiffCellSmoother& cells, const AlignedArray<float>& r,
                                                         AlignedArray<float>& rest) {
  std::vector<StiffCellSmoother::Vector24f> before;
  for (std::size_t e = 0; e < cells.nodes.size(); ++e) {
    before.emplace_back(cells.inverses[e] * gather_nodes(cells.nodes[e], r));
    const Eigen::Matrix<float, 192, 1> force = cells.rows[e].transpose() * before[e];
    for (int m = 0; m < 64; ++m)
      if (const int slot = cells.reached[e][m]; slot >= 0) add_at_node(slot, -force.segment<3>(3 * m), rest);
  }
  return before;
}

double correct_after(const StiffCellSmoother& cells, const AlignedArray<float>& r,
                     const std::vector<StiffCellSmoother::Vector24f>& before, AlignedArray<float>& z) {
  const std::size_t count = cells.nodes.size();
  std::vector<StiffCellSmoother::Vector24f> local(count), after(count);
  double gain = 0;
  const auto gain_by = [](const StiffCellSmoother::Vector24f& a, const StiffCellSmoother::Vector24f& b) {
    return a.cast<double>().dot(b.cast<double>());
  };
  for (std::size_t e = 0; e < count; ++e) {  // (r - rest) . z = A L r . z, and r . L r
    local[e] = gather_nodes(cells.nodes[e], r);
    gain += gain_by(before[e], multiply(cells, e, z)) + gain_by(before[e], local[e]);
  }
  for (std::size_t e = 0; e < count; ++e) add_at_nodes(cells.nodes[e], before[e], z);
  for (std::size_t e = 0; e < count; ++e) {
    after[e] = cells.inverses[e] * (local[e] - multiply(cells, e, z));
    gain += gain_by(after[e], local[e]);
  }
  for (std::size_t e = 0; e < count; ++e) add_at_nodes(cells.nodes[e], after[e], z);
  return gain;
}

}  // namespace umax
