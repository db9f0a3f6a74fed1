#include "core/linear/multigrid/multigrid_level.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr int coarse_bricks_per_block = 1;  // each takes from eight fine ones

Vector3i place_of(const Brick& brick) {
  return {brick.place[0], brick.place[1], brick.place[2]};
}

using Restriction = void (*)(const Transfer&, const float* fine, float* coarse, int first, int last);

void restrict_by(Restriction restriction, const MultigridLevel& fine, const AlignedArray<float>& from,
                 const MultigridLevel& coarse, AlignedArray<float>& to) {
  const Transfer transfer = transfer_between(fine, coarse);
  for_each_block(
      coarse.lattice(), [&](int first, int last) { restriction(transfer, from.data(), to.data(), first, last); },
      coarse_bricks_per_block);
}

}  // namespace

Transfer transfer_between(const MultigridLevel& fine, const MultigridLevel& coarse) {
  Transfer transfer{
      coarse.lattice().bricks.data(), fine.lattice().bricks.data(), fine.parents.data(), fine.children.data(), {}};
  std::copy_n(fine.factor.data(), 3, transfer.factor);
  return transfer;
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

void restrict_vector(const MultigridLevel& fine, const AlignedArray<float>& from, const MultigridLevel& coarse,
                     AlignedArray<float>& to) {
  restrict_by(kernels_of(fine).restrict_vectors, fine, from, coarse, to);
}

void coarsen_matrix(MultigridLevel& fine, MultigridLevel& coarse) {
  std::vector<std::uint16_t> unresolved(coarse.lattice().bricks.size() * brick_lines, 0);
  const FrameCoarsening task{transfer_between(fine, coarse), fine.matrix.frames.data(), coarse.matrix.frames.data(),
                             unresolved.data()};
  for_each_block(
      coarse.lattice(), [&](int first, int last) { kernels_of(fine).coarsen_frames(task, first, last); },
      coarse_bricks_per_block);
  resolve_frames(unresolved, coarse.matrix.frames);  // rotations that nearly cancel

  // masses, those of fixed nodes included; then which nodes are fixed
  AlignedArray<float>& weights = fine.x[0];  // free at this time, and large enough
  const auto own_slots = [&](const auto& visit) {
    for_each_block(fine.lattice(), [&](int first, int last) {
      for (std::size_t slot = std::size_t(first) * brick_slots; slot < std::size_t(last) * brick_slots; ++slot)
        visit(slot);
    });
  };
  own_slots([&](std::size_t slot) { weights[slot] = std::abs(fine.matrix.diagonal[slot]); });
  restrict_by(kernels_of(fine).restrict_numbers, fine, weights, coarse, coarse.matrix.diagonal);
  own_slots([&](std::size_t slot) { weights[slot] = 0; });
  const auto mark_fixed = [&](int b) {
    for (int slot = 0; slot < brick_slots; ++slot) {
      const Vector3i at = place_in_brick(slot).cwiseProduct(fine.factor);
      const int parent = (at[0] / brick_edge + 1) * 9 + (at[1] / brick_edge + 1) * 3 + at[2] / brick_lanes + 1;
      const std::size_t brick = std::size_t(fine.parents[b].fine[parent]);
      const int line = brick_edge * (at[0] % brick_edge) + at[1] % brick_edge;
      float& w = coarse.matrix.diagonal[std::size_t(b) * brick_slots + slot];
      if (fine.matrix.diagonal[brick * brick_slots + line * brick_lanes + at[2] % brick_lanes] < 0) w = -w;
    }
  };
  for_each_block(
      coarse.lattice(),
      [&](int first, int last) {
        for (int b = first; b < last; ++b) mark_fixed(b);
      },
      coarse_bricks_per_block);
}

void invert_blocks(MultigridLevel& level) {
  const BlockInversion task{level.lattice().bricks.data(), &level.op.float_constants, level.matrix.frames.data(),
                            level.matrix.diagonal.data(), level.inverse.data()};
  for_each_block(level.lattice(), [&](int first, int last) { kernels_of(level).invert_blocks(task, first, last); });
}

}  // namespace umax
