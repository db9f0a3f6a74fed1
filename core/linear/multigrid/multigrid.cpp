#include "core/linear/multigrid/multigrid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/linear/multigrid/chebyshev.h"
#include "core/linear/multigrid/multigrid_cycle.h"

namespace umax {
namespace {

// nodes that are factored without coarsening them further: of few hexes, and at most of many
constexpr Eigen::Index least_dense = 166, most_dense = 1000;
constexpr Eigen::Index nodes_per_dense = 1000;       // of the finest level, for which one more is worth it
constexpr Eigen::Index largest_stalled_dense = 600;  // the same where coarsening no longer removes nodes
constexpr double stalled = 0.9;                      // share of the nodes that is left
constexpr double interval = 8;                       // the smoother's: largest over smallest eigenvalue
constexpr double nearly_short = 1.5;                 // edges up to this times the shortest are coarsened too
constexpr double stored_rows = 1.0 / 400;            // stiff hexes per node up to which A's rows are stored for them

Vector3i coarsening_factor(const Vector3d& cell_size) {
  const double shortest = cell_size.minCoeff();
  return (cell_size.array() <= nearly_short * shortest).select(Vector3i::Constant(2), Vector3i::Constant(1));
}

// as (keep, momentum, gain) of iterates: x_{n+1} = (1 + m) x_n - m x_{n-1} + g D^-1 (b - A x_n)
std::vector<ChebyshevStep> chebyshev_steps(double largest, int degree) {
  ChebyshevRecurrence<double> recurrence(largest, interval);
  std::vector<ChebyshevStep> steps{{1, 0, float(recurrence.first_gain())}};
  for (int n = 1; n < degree; ++n) {
    const auto [momentum, gain] = recurrence.next();
    steps.push_back({float(1 + momentum), float(-momentum), float(gain)});
  }
  return steps;
}

// calls visit(slot) for the set bits of masks
template <class Visit>
void for_each_set(const std::vector<std::uint16_t>& masks, const Visit& visit) {
  for (std::size_t line = 0; line < masks.size(); ++line)
    for (int lane = 0; lane < brick_lanes; ++lane)
      if (masks[line] >> lane & 1) visit(int(line * brick_lanes) + lane);
}

// the last level's matrix, unknowns in the order of dense_slots; fixed nodes are ones
MatrixXd assemble(const MultigridLevel& level, const std::vector<int>& slots) {
  std::vector<int> index(level.lattice().num_slots(), -1);
  for (std::size_t i = 0; i < slots.size(); ++i) index[slots[i]] = int(i);
  MatrixXd A = MatrixXd::Zero(3 * Eigen::Index(slots.size()), 3 * Eigen::Index(slots.size()));
  for (std::size_t i = 0; i < slots.size(); ++i)
    A.diagonal().segment<3>(3 * Eigen::Index(i)).setConstant(double(level.matrix.diagonal[slots[i]]));
  for_each_set(level.lattice().cell_masks, [&](int cell) {
    std::array<int, 8> places = corner_slots(level.lattice(), cell);
    for (int& place : places) place = index[place];
    add_turned_stiffness(frame_at(level.matrix.frames, cell), level.shape.stiffness, places, places, A);
  });
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (!(level.matrix.diagonal[slots[i]] > 0))
      for (int c = 0; c < 3; ++c) {
        A.row(3 * Eigen::Index(i) + c).setZero();
        A.col(3 * Eigen::Index(i) + c).setZero();
        A(3 * Eigen::Index(i) + c, 3 * Eigen::Index(i) + c) = 1;
      }
  return A;
}

}  // namespace

Multigrid make_multigrid(BrickLattice lattice, double poisson, const MultigridOptions& options) {
  Multigrid multigrid;
  multigrid.local_contrast = options.local_contrast;
  const auto add_level = [&](BrickLattice bricks) {
    MultigridLevel& level = multigrid.levels.emplace_back();
    level.shape = make_box_shape(bricks.cell_size, poisson);
    level.op = make_hex_operator(std::move(bricks), level.shape, options.instruction_set);
    level.largest_eigenvalue = largest_jacobi_eigenvalue(level.shape);
    level.steps = chebyshev_steps(level.largest_eigenvalue, options.degree);
  };
  add_level(std::move(lattice));
  const Eigen::Index largest_dense =
      std::clamp(multigrid.levels.front().lattice().num_nodes / nodes_per_dense, least_dense, most_dense);
  while (multigrid.levels.back().lattice().num_nodes > largest_dense) {
    MultigridLevel& fine = multigrid.levels.back();
    fine.factor = coarsening_factor(fine.lattice().cell_size);
    BrickLattice coarse = coarsen(fine.lattice(), fine.factor);
    const bool isotropic = fine.factor == Vector3i::Constant(2);
    if (isotropic && double(coarse.num_nodes) > stalled * double(fine.lattice().num_nodes)) break;
    connect(fine, coarse);
    add_level(std::move(coarse));
  }
  const BrickLattice& last = multigrid.levels.back().lattice();
  multigrid.has_dense = last.num_nodes <= std::max(largest_dense, largest_stalled_dense);
  if (multigrid.has_dense) for_each_set(last.node_masks, [&](int slot) { multigrid.dense_slots.push_back(slot); });
  for (MultigridLevel& level : multigrid.levels) allocate(level, &level == &multigrid.levels.front());
  return multigrid;
}

void set_up(Multigrid& multigrid) {
  set_up_levels(multigrid);
  factorize_last(multigrid);
  set_up_stiff_cells(multigrid);
}

void set_up_levels(Multigrid& multigrid) {
  for (std::size_t depth = 0; depth < multigrid.levels.size(); ++depth) {
    if (depth > 0) coarsen_matrix(multigrid.levels[depth - 1], multigrid.levels[depth]);
    invert_blocks(multigrid.levels[depth]);
  }
}

void set_up_stiff_cells(Multigrid& multigrid) {
  const MultigridLevel& finest = multigrid.levels.front();
  if (multigrid.levels.size() > 1)
    multigrid.stiff_cell_smoother =
        make_stiff_cell_smoother(finest.op, finest.matrix, finest.shape.stiffness, multigrid.local_contrast,
                                 Eigen::Index(stored_rows * double(finest.lattice().num_nodes)));
  const StiffCellSmoother& stiff = multigrid.stiff_cell_smoother;
  if (!stiff.nodes.empty() && multigrid.rest.size() == 0) multigrid.rest = AlignedArray<float>(finest.x[0].size());
  if (!stiff.nodes.empty() && stiff.rows.empty() && multigrid.corrected.size() == 0)
    multigrid.corrected = AlignedArray<float>(finest.x[0].size());
}

void factorize_last(Multigrid& multigrid) {
  if (multigrid.has_dense)
    multigrid.dense = make_envelope_cholesky(assemble(multigrid.levels.back(), multigrid.dense_slots));
}

const AlignedArray<float>& precondition(Multigrid& multigrid, const AlignedArray<float>& r, double& product) {
  const MultigridLevel& level = multigrid.levels.front();
  const StiffCellSmoother& stiff = multigrid.stiff_cell_smoother;
  if (stiff.nodes.empty()) {
    const AlignedArray<float>& z = v_cycle(multigrid, 0, r, product);
    if (multigrid.levels.size() == 1) product = dot(level.lattice(), r, z);
    return z;
  }
  // local solves, V-cycle, local solves, each on what the one before has left: symmetric
  if (!stiff.rows.empty()) {
    copy(level.lattice(), r, multigrid.rest);
    const std::vector<StiffCellSmoother::Vector24f> before = correct_before(stiff, r, multigrid.rest);
    AlignedArray<float>& z = v_cycle(multigrid, 0, multigrid.rest, product);
    product += correct_after(stiff, r, before, z);
    return z;
  }
  AlignedArray<float>& z = multigrid.corrected;
  std::fill(z.begin(), z.end(), 0.f);
  add_corrections(stiff, r, z);
  residual(level.op, level.matrix, r, z, multigrid.rest);
  const AlignedArray<float>& correction = v_cycle(multigrid, 0, multigrid.rest, product);
  for_each_block(level.lattice(),
                 [&](int first, int last) { kernels_of(level).turn(correction.data(), 1, z.data(), first, last); });
  residual(level.op, level.matrix, r, z, multigrid.rest);
  add_corrections(stiff, multigrid.rest, z);
  product = dot(level.lattice(), r, z);
  return z;
}

}  // namespace umax
