// A brick: 8 x 8 lines of 16 lattice points along z, the unit in which the matrix-free solver stores a fine cage. Plain
// data, which the kernels of every instruction set read: this header includes nothing that could end up compiled for
// one of them.
//
// A brick owns the nodes (I, J, K) with I / 8, J / 8, K / 16 equal to its place, and the cells of the same numbers.
// Values stand line by line (8 i + j), in a line component by component, in a component 16 lanes along z.
#pragma once

#include <cstddef>
#include <cstdint>

namespace umax {

inline constexpr int brick_edge = 8;    // lines along x and along y
inline constexpr int brick_lanes = 16;  // points along z
inline constexpr int brick_lines = brick_edge * brick_edge;
inline constexpr int brick_slots = brick_lines * brick_lanes;

/// Components per slot of the arrays that go with a lattice of bricks.
inline constexpr int vector_components = 3;   // a displacement or force per node
inline constexpr int frame_components = 9;    // sqrt(s) R of each cell, row-major: 0 where there is no cell
inline constexpr int inverse_components = 6;  // (xx, xy, xz, yy, yz, zz) of a symmetric 3 x 3 block per node

struct Brick {
  std::int32_t place[3] = {0, 0, 0};  // in bricks
  std::int32_t near[18] = {};         // bricks at place + (di, dj, dk): near_index(); 0: none there
  std::uint64_t cell_lines = 0;       // bit 8 i + j: the line has cells
  std::uint64_t node_lines = 0;       // bit 8 i + j: the line has nodes
  bool continues = false;             // the brick before it in the list is the one below it
};

/// Bricks side by side along x that a task sweeps in one go: only before the first of them cells are computed twice.
inline constexpr int longest_run = 4;
struct BrickRun {
  std::int32_t bricks[longest_run] = {};
  std::int32_t count = 0;
  std::int32_t first_column = 0;  // of the task's longest_run columns: the first brick's
};

/// di, dj in -1 .. 1, dk in 0 .. 1.
constexpr int near_index(int di, int dj, int dk) {
  return 6 * (di + 1) + 2 * (dj + 1) + dk;
}

/// First value of a line in an array with that many components per slot.
constexpr std::size_t line_offset(int brick, int line, int components) {
  return (std::size_t(brick) * brick_lines + line) * components * brick_lanes;
}

}  // namespace umax
