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
constexpr int coarsest_sweeps = 4;                   // of the smoother, where the last level is not factored

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

Vector3i place_of(const Brick& brick) {
  return {brick.place[0], brick.place[1], brick.place[2]};
}

void connect(MultigridLevel& fine, const BrickLattice& coarse) {
  fine.parents.assign(coarse.bricks.size(), {});
  for (std::size_t b = 1; b < coarse.bricks.size(); ++b)
    for (int n = 0; n < 27; ++n) {
      const Vector3i step(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
      fine.parents[b].fine[n] = find_brick(fine.lattice(), place_of(coarse.bricks[b]).cwiseProduct(fine.factor) + step);
    }
  fine.children.assign(fine.lattice().bricks.size(), {});
  for (std::size_t b = 1; b < fine.lattice().bricks.size(); ++b) {
    const Vector3i place = place_of(fine.lattice().bricks[b]), parent = place.cwiseQuotient(fine.factor);
    for (int axis = 0; axis < 3; ++axis) fine.children[b].half[axis] = place[axis] - parent[axis] * fine.factor[axis];
    for (int n = 0; n < 8; ++n) fine.children[b].coarse[n] = find_brick(coarse, parent + corner(n));
  }
}

void allocate(MultigridLevel& level, bool is_first) {
  const std::size_t slots = level.lattice().num_slots();
  level.matrix = make_hex_matrix<float>(level.lattice());
  level.inverse = AlignedArray<float>(slots * inverse_components);
  if (!is_first) level.b = AlignedArray<float>(slots * vector_components);
  for (AlignedArray<float>& x : level.x) x = AlignedArray<float>(slots * vector_components);
}

Transfer transfer_between(const MultigridLevel& fine, const MultigridLevel& coarse) {
  Transfer transfer{
      coarse.lattice().bricks.data(), fine.lattice().bricks.data(), fine.parents.data(), fine.children.data(), {}};
  std::copy_n(fine.factor.data(), 3, transfer.factor);
  return transfer;
}

const MultigridKernels& kernels_of(const MultigridLevel& level) {
  return multigrid_kernels(level.op.instruction_set);
}

template <class Call>
void run(const BrickLattice& lattice, const Call& call) {
  for_each_column(lattice, [&](int first, int last) {
    call(first, last);
    return 0.0;
  });
}

using Restriction = void (*)(const Transfer&, const float* fine, float* coarse, int first, int last);

void restrict_to(const MultigridLevel& fine, const AlignedArray<float>& from, MultigridLevel& coarse,
                 AlignedArray<float>& to, Restriction restriction) {
  const Transfer transfer = transfer_between(fine, coarse);
  run(coarse.lattice(), [&](int first, int last) { restriction(transfer, from.data(), to.data(), first, last); });
}

void coarsen_matrix(MultigridLevel& fine, MultigridLevel& coarse) {
  std::vector<std::uint16_t> unresolved(coarse.lattice().bricks.size() * brick_lines, 0);
  const FrameCoarsening task{transfer_between(fine, coarse), fine.matrix.frames.data(), coarse.matrix.frames.data(),
                             unresolved.data()};
  run(coarse.lattice(), [&](int first, int last) { kernels_of(fine).coarsen_frames(task, first, last); });
  resolve_frames(unresolved, coarse.matrix.frames);  // rotations that nearly cancel

  // masses, those of fixed nodes included; then which nodes are fixed
  AlignedArray<float>& weights = fine.x[0];  // free at this time, and large enough
  for (std::size_t slot = 0; slot < fine.matrix.diagonal.size(); ++slot)
    weights[slot] = std::abs(fine.matrix.diagonal[slot]);
  restrict_to(fine, weights, coarse, coarse.matrix.diagonal, kernels_of(fine).restrict_numbers);
  std::fill(weights.begin(), weights.end(), 0.f);
  for (std::size_t b = 1; b < coarse.lattice().bricks.size(); ++b)
    for (int slot = 0; slot < brick_slots; ++slot) {
      const Vector3i at = place_in_brick(slot).cwiseProduct(fine.factor);
      const int parent = (at[0] / brick_edge + 1) * 9 + (at[1] / brick_edge + 1) * 3 + at[2] / brick_lanes + 1;
      const std::size_t brick = std::size_t(fine.parents[b].fine[parent]);
      const int line = brick_edge * (at[0] % brick_edge) + at[1] % brick_edge;
      float& w = coarse.matrix.diagonal[b * brick_slots + slot];
      if (fine.matrix.diagonal[brick * brick_slots + line * brick_lanes + at[2] % brick_lanes] < 0) w = -w;
    }
}

void invert_blocks(MultigridLevel& level) {
  const BlockInversion task{level.lattice().bricks.data(), &level.op.float_constants, level.matrix.frames.data(),
                            level.matrix.diagonal.data(), level.inverse.data()};
  run(level.lattice(), [&](int first, int last) { kernels_of(level).invert_blocks(task, first, last); });
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

// Both return which of the two iterates is current, they alternate.
int smooth(MultigridLevel& level, const AlignedArray<float>& b, int current, double& product) {
  for (const ChebyshevStep& step : level.steps) {
    product = chebyshev(level.op, level.matrix, level.inverse, step, b, level.x[current], level.x[1 - current]);
    current = 1 - current;
  }
  return current;
}

int smooth_from_zero(MultigridLevel& level, const AlignedArray<float>& b, double& product) {
  jacobi_from_zero(level, b, level.steps[0].gain);
  int current = 0;
  for (std::size_t n = 1; n < level.steps.size(); ++n) {
    ChebyshevStep step = level.steps[n];
    if (n == 1) step.momentum = 0;  // the iterate before is zero
    product = chebyshev(level.op, level.matrix, level.inverse, step, b, level.x[current], level.x[1 - current]);
    current = 1 - current;
  }
  return current;
}

// returns which of the level's two arrays has x ~ A^-1 b; product: b . x
AlignedArray<float>& cycle(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& b, double& product) {
  MultigridLevel& level = multigrid.levels[depth];
  if (depth + 1 == multigrid.levels.size()) {
    if (multigrid.has_dense) return solve_dense(multigrid, b);
    int current = smooth_from_zero(level, b, product);
    for (int sweep = 1; sweep < coarsest_sweeps; ++sweep) current = smooth(level, b, current, product);
    return level.x[current];
  }
  int current = smooth_from_zero(level, b, product);
  restrict_residual(multigrid, depth, b, current);
  prolong(multigrid, depth, cycle(multigrid, depth + 1, multigrid.levels[depth + 1].b, product), current);
  current = smooth(level, b, current, product);
  return level.x[current];
}

}  // namespace

AlignedArray<float>& solve_dense(Multigrid& multigrid, const AlignedArray<float>& b) {
  MultigridLevel& level = multigrid.levels.back();
  const std::vector<int>& slots = multigrid.dense_slots;
  VectorXd x;
  from_bricks(slots, b, x);
  for (std::size_t i = 0; i < slots.size(); ++i)
    if (!(level.matrix.diagonal[slots[i]] > 0)) x.segment<3>(3 * Eigen::Index(i)).setZero();
  multigrid.dense.solveInPlace(x);
  to_bricks(slots, x, level.x[0]);
  return level.x[0];
}

void jacobi_from_zero(MultigridLevel& level, const AlignedArray<float>& b, float gain) {
  run(level.lattice(), [&](int first, int last) {
    kernels_of(level).block_jacobi(level.inverse.data(), b.data(), gain, level.x[0].data(), first, last);
  });
}

void restrict_residual(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& b, int current) {
  MultigridLevel &level = multigrid.levels[depth], &coarse = multigrid.levels[depth + 1];
  residual(level.op, level.matrix, b, level.x[current], level.x[1 - current]);
  restrict_to(level, level.x[1 - current], coarse, coarse.b, kernels_of(level).restrict_vectors);
}

void prolong(Multigrid& multigrid, std::size_t depth, const AlignedArray<float>& correction, int current) {
  MultigridLevel& level = multigrid.levels[depth];
  const Transfer transfer = transfer_between(level, multigrid.levels[depth + 1]);
  run(level.lattice(), [&](int first, int last) {
    kernels_of(level).prolong(transfer, correction.data(), level.matrix.diagonal.data(), level.x[current].data(), first,
                              last);
  });
}

Multigrid make_multigrid(BrickLattice lattice, double poisson, const MultigridOptions& options) {
  Multigrid multigrid;
  multigrid.local_contrast = options.local_contrast;
  const auto add_level = [&](BrickLattice bricks) {
    MultigridLevel& level = multigrid.levels.emplace_back();
    level.shape = make_box_shape(bricks.cell_size, poisson);
    level.op = make_hex_operator(std::move(bricks), level.shape, options.instruction_set);
    level.steps = chebyshev_steps(largest_jacobi_eigenvalue(level.shape), options.degree);
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
  for (std::size_t depth = 0; depth < multigrid.levels.size(); ++depth) {
    if (depth > 0) coarsen_matrix(multigrid.levels[depth - 1], multigrid.levels[depth]);
    invert_blocks(multigrid.levels[depth]);
  }
  const MultigridLevel& finest = multigrid.levels.front();
  if (multigrid.levels.size() > 1)
    multigrid.stiff_cells = find_stiff_cells(finest.op, finest.matrix, finest.shape.stiffness, multigrid.local_contrast,
                                             Eigen::Index(stored_rows * double(finest.lattice().num_nodes)));
  const StiffCells& stiff = multigrid.stiff_cells;
  if (!stiff.nodes.empty() && multigrid.rest.size() == 0) multigrid.rest = AlignedArray<float>(finest.x[0].size());
  if (!stiff.nodes.empty() && stiff.rows.empty() && multigrid.corrected.size() == 0)
    multigrid.corrected = AlignedArray<float>(finest.x[0].size());
  if (multigrid.has_dense) multigrid.dense.compute(assemble(multigrid.levels.back(), multigrid.dense_slots));
}

const AlignedArray<float>& precondition(Multigrid& multigrid, const AlignedArray<float>& r, double& product) {
  const MultigridLevel& level = multigrid.levels.front();
  const StiffCells& stiff = multigrid.stiff_cells;
  if (stiff.nodes.empty()) {
    const AlignedArray<float>& z = cycle(multigrid, 0, r, product);
    if (multigrid.levels.size() == 1) product = dot(level.lattice(), r, z);
    return z;
  }
  // local solves, V-cycle, local solves, each on what the one before has left: symmetric
  if (!stiff.rows.empty()) {
    copy(level.lattice(), r, multigrid.rest);
    const std::vector<StiffCells::Vector24f> before = correct_before(stiff, r, multigrid.rest);
    AlignedArray<float>& z = cycle(multigrid, 0, multigrid.rest, product);
    product += correct_after(stiff, r, before, z);
    return z;
  }
  AlignedArray<float>& z = multigrid.corrected;
  std::fill(z.begin(), z.end(), 0.f);
  add_corrections(stiff, r, z);
  residual(level.op, level.matrix, r, z, multigrid.rest);
  const AlignedArray<float>& correction = cycle(multigrid, 0, multigrid.rest, product);
  run(level.lattice(),
      [&](int first, int last) { kernels_of(level).turn(correction.data(), 1, z.data(), first, last); });
  residual(level.op, level.matrix, r, z, multigrid.rest);
  add_corrections(stiff, multigrid.rest, z);
  product = dot(level.lattice(), r, z);
  return z;
}

}  // namespace umax
