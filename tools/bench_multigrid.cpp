// Figures of the matrix-free solver on blocks of hexes.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/hex_operator.h"
#include "tools/bench.h"

namespace umax {
namespace {

Cells block_cells(int n) {
  Cells cells(Eigen::Index(n) * n * n, 3);
  Eigen::Index e = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) cells.row(e++) << i, j, k;
  return cells;
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// least and median time [ms] of calls
template <class Call>
std::pair<double, double> least_and_median(int calls, const Call& call) {
  std::vector<double> ms;
  for (int i = 0; i < calls; ++i) {
    const auto start = std::chrono::steady_clock::now();
    call();
    ms.push_back(milliseconds_since(start));
  }
  std::sort(ms.begin(), ms.end());
  return {ms.front(), ms[ms.size() / 2]};
}

BenchRows operator_speed(int n, double limit, int calls) {
  const BrickLattice bricks = make_brick_lattice(block_cells(n), Vector3d::Constant(1.0 / n));
  const HexOperator op = make_hex_operator(bricks, make_box_shape(bricks.cell_size, 0.3));
  HexMatrix<float> matrix = make_hex_matrix<float>(bricks);
  for (std::size_t line = 0; line < bricks.bricks.size() * brick_lines; ++line)
    for (int k = 0; k < brick_lanes; ++k) {
      if (bricks.cell_masks[line] >> k & 1)
        for (int r = 0; r < 9; r += 4) matrix.frames[(line * 9 + r) * brick_lanes + k] = 700;
      if (bricks.node_masks[line] >> k & 1) matrix.diagonal[line * brick_lanes + k] = 1;
    }
  AlignedArray<float> x(bricks.num_slots() * vector_components), y(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = matrix.diagonal[i / 48 * 16 + i % 16] > 0 ? float(int(i * 7919 % 1000)) * 1e-3f : 0;
  const auto [least, median] = least_and_median(calls, [&] { apply(op, matrix, x, y); });
  const double per_hex = 1e6 / double(bricks.num_cells);
  return {at_most(fmt::format("operator, float, {} hexes, 2 threads", bricks.num_cells), median * per_hex, limit,
                  "ns/hex", fmt::format("least {:.2f}", least * per_hex))};
}

}  // namespace

std::vector<Benchmark> multigrid_benchmarks() {
  return {
      {"operator", false, false,
       [] {
         BenchRows rows = operator_speed(46, 4, 200);
         for (const BenchRow& row : operator_speed(100, 10, 30)) rows.push_back(row);
         return rows;
       }},
  };
}

}  // namespace umax
