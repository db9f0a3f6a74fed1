#include "embedding/cage/cage_cells.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "embedding/surface/triangle_box.h"

namespace umax {
namespace {

// cells are tested as open boxes, smaller by this share of an edge on all sides; less than cell_table.h's
// face_tolerance
constexpr double shrink = 1e-10;
constexpr double spare = 1e-6;  // [cells] by which blocks of cells are tested larger

// the cells on both sides of a grid plane that holds a triangle; equal at the border of the grid
struct PlanePair {
  Cell low{}, high{};
};

struct Touch {
  std::vector<Cell> cells;
  std::vector<PlanePair> pairs;
};

class Toucher {
 public:
  Toucher(const CageGrid& grid, Touch& out) : grid_(grid), out_(out) {
    recent_.fill({-1, -1, -1});
    for (auto& pairs : recent_pairs_) pairs.fill({{-1, -1, -1}, {-1, -1, -1}});
  }

  void add(std::array<Vector3d, 3> corners) {  // in grid coordinates
    const Vector3d min = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Vector3d max = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    Cell low, high;
    int plane_axis = -1;
    for (int axis = 0; axis < 3; ++axis) {
      int first = int(std::floor(min[axis] + shrink)), last = int(std::ceil(max[axis] - shrink)) - 1;
      if (last < first) {  // in a grid plane: look at the layer below
        if (plane_axis < 0) plane_axis = axis;
        const double shift = min[axis] - (last + 0.5);
        for (Vector3d& corner : corners) corner[axis] -= shift;
        first = last;
      }
      low[std::size_t(axis)] = first;
      high[std::size_t(axis)] = last;
    }
    if (low == high && plane_axis < 0) return keep(low);
    test(low, high, corners, plane_axis);
  }

 private:
  // A triangle that is long and thin, or large, meets few of the cells in its box: blocks of cells that it does not meet
  // are left out at once.
  void test(const Cell& low, const Cell& high, const std::array<Vector3d, 3>& corners, int plane_axis) {
    constexpr int few_cells = 4;
    int longest = 0, num_cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int size = high[std::size_t(axis)] - low[std::size_t(axis)] + 1;
      num_cells = std::min(num_cells * std::min(size, few_cells + 1), few_cells + 1);
      if (size > high[std::size_t(longest)] - low[std::size_t(longest)] + 1) longest = axis;
    }
    if (num_cells <= few_cells) {
      for_each_cell(low, high, [&](const Cell& cell) { return test(cell, corners, plane_axis), true; });
      return;
    }
    if (for_each_cell(low, high, [&](const Cell& cell) { return is_recent(pair_at(cell, plane_axis), plane_axis); }))
      return;
    if (!meets_block(low, high, corners)) return;
    const auto axis = std::size_t(longest);
    Cell middle = high, next = low;
    middle[axis] = low[axis] + (high[axis] - low[axis]) / 2;
    next[axis] = middle[axis] + 1;
    test(low, middle, corners, plane_axis);
    test(next, high, corners, plane_axis);
  }

  // with room to spare, so that no rounding leaves out a cell that the triangle meets
  static bool meets_block(const Cell& low, const Cell& high, std::array<Vector3d, 3> corners) {
    const Vector3d first(low[0], low[1], low[2]), end(high[0] + 1, high[1] + 1, high[2] + 1);
    const Vector3d centre = 0.5 * (first + end);
    for (Vector3d& corner : corners) corner -= centre;
    return triangle_meets_box(corners, 0.5 * (end - first) + Vector3d::Constant(spare));
  }

  // until visit(cell) returns false; returns whether it never did
  template <class Visit>
  static bool for_each_cell(const Cell& low, const Cell& high, const Visit& visit) {
    for (int i = low[0]; i <= high[0]; ++i)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int k = low[2]; k <= high[2]; ++k)
          if (!visit({i, j, k})) return false;
    return true;
  }

  // both cells are the same where there is no plane
  PlanePair pair_at(const Cell& cell, int plane_axis) const {
    PlanePair pair{clamped(cell), cell};
    if (plane_axis >= 0) ++pair.high[std::size_t(plane_axis)];
    pair.high = clamped(pair.high);
    return pair;
  }

  void test(const Cell& cell, std::array<Vector3d, 3> corners, int plane_axis) {
    const PlanePair pair = pair_at(cell, plane_axis);
    if (is_recent(pair, plane_axis)) return;
    for (Vector3d& corner : corners) corner -= Vector3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5);
    if (!triangle_meets_box(corners, Vector3d::Constant(0.5 - shrink))) return;
    if (plane_axis < 0) return keep(cell);
    recent_pairs_[std::size_t(plane_axis)][slot_of(pair.low)] = pair;
    out_.pairs.push_back(pair);
  }

  void keep(const Cell& cell) {
    const Cell inside = clamped(cell);
    const std::size_t slot = slot_of(inside);
    if (recent_[slot] == inside) return;  // most triangles of a fine mesh fall into a cell that was just seen
    recent_[slot] = inside;
    out_.cells.push_back(inside);
  }

  bool is_recent(const PlanePair& pair, int plane_axis) const {
    if (plane_axis < 0) return recent_[slot_of(pair.low)] == pair.low;
    const PlanePair& recent = recent_pairs_[std::size_t(plane_axis)][slot_of(pair.low)];
    return recent.low == pair.low && recent.high == pair.high;
  }

  static std::size_t slot_of(const Cell& cell) {
    return std::size_t(cell[0] * 73 + cell[1] * 19 + cell[2]) % num_slots;
  }

  Cell clamped(Cell cell) const {
    for (int axis = 0; axis < 3; ++axis)
      cell[std::size_t(axis)] = std::clamp(cell[std::size_t(axis)], 0, grid_.size[axis] - 1);
    return cell;
  }

  const CageGrid& grid_;
  Touch& out_;
  static constexpr std::size_t num_slots = 1024;
  std::array<Cell, num_slots> recent_;
  std::array<std::array<PlanePair, num_slots>, 3> recent_pairs_;  // by the plane's axis
};

Touch touch_cells(const Points& positions, const Triangles& triangles, const CageGrid& grid) {
  constexpr int block_size = 16384;
  const int num_triangles = int(triangles.rows()), num_blocks = (num_triangles + block_size - 1) / block_size;
  std::vector<Touch> blocks(static_cast<std::size_t>(num_blocks));
  tbb::parallel_for(0, num_blocks, [&](int b) {
    Toucher toucher(grid, blocks[std::size_t(b)]);
    for (int t = b * block_size; t < std::min(num_triangles, (b + 1) * block_size); ++t) {
      std::array<Vector3d, 3> corners;
      for (int k = 0; k < 3; ++k)
        corners[std::size_t(k)] =
            (positions.row(triangles(t, k)).transpose() - grid.origin).cwiseQuotient(grid.cell_size);
      toucher.add(corners);
    }
  });
  Touch all;
  for (const Touch& block : blocks) {
    all.cells.insert(all.cells.end(), block.cells.begin(), block.cells.end());
    all.pairs.insert(all.pairs.end(), block.pairs.begin(), block.pairs.end());
  }
  return all;
}

void sort_unique(std::vector<Cell>& cells) {
  tbb::parallel_sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

bool contains(const std::vector<Cell>& sorted, const Cell& cell) {
  return std::binary_search(sorted.begin(), sorted.end(), cell);
}

// A column's untouched cells between two stops (touched cells and cells beside a grid plane that holds a triangle) are
// all inside or all outside, and so is a cell beside such a plane: one query each.
struct Query {
  Cell first{};
  int length = 1;
};

std::vector<Query> list_queries(const std::vector<Cell>& stops, const std::vector<Cell>& touched) {
  std::vector<Query> queries;
  for (std::size_t s = 0; s < stops.size(); ++s) {
    if (!contains(touched, stops[s])) queries.push_back({stops[s], 1});
    if (s + 1 == stops.size() || stops[s + 1][0] != stops[s][0] || stops[s + 1][1] != stops[s][1]) continue;
    const int gap = stops[s + 1][2] - stops[s][2] - 1;
    if (gap > 0) queries.push_back({{stops[s][0], stops[s][1], stops[s][2] + 1}, gap});
  }
  return queries;
}

std::vector<Cell> inside_cells(const Solid& solid, const CageGrid& grid, const std::vector<Query>& queries) {
  std::vector<Cell> points, inside;
  for (const Query& query : queries) points.push_back(query.first);
  const PointGrid centres{grid.origin + 0.5 * grid.cell_size, grid.cell_size, grid.size};
  const std::vector<char> answers = are_inside(solid, centres, points);
  for (std::size_t q = 0; q < queries.size(); ++q)
    for (int k = 0; answers[q] && k < queries[q].length; ++k)
      inside.push_back({queries[q].first[0], queries[q].first[1], queries[q].first[2] + k});
  return inside;
}

}  // namespace

CageCells cage_cells(const Solid& solid, const Points& positions, const Triangles& triangles, const CageGrid& grid) {
  Touch touch = touch_cells(positions, triangles, grid);
  sort_unique(touch.cells);
  std::vector<Cell> stops = touch.cells;
  for (const PlanePair& pair : touch.pairs) {
    stops.push_back(pair.low);
    stops.push_back(pair.high);
  }
  sort_unique(stops);

  const std::vector<Cell> inside = inside_cells(solid, grid, list_queries(stops, touch.cells));
  CageCells result;
  result.cells = touch.cells;
  result.cells.insert(result.cells.end(), inside.begin(), inside.end());
  sort_unique(result.cells);

  // faces in grid planes with nothing filled on either side
  std::vector<Cell> lone;
  for (const PlanePair& pair : touch.pairs)
    if (!contains(result.cells, pair.low) && !contains(result.cells, pair.high)) lone.push_back(pair.low);
  if (!lone.empty()) {
    sort_unique(lone);
    touch.cells.insert(touch.cells.end(), lone.begin(), lone.end());
    sort_unique(touch.cells);
    result.cells.insert(result.cells.end(), lone.begin(), lone.end());
    sort_unique(result.cells);
  }
  result.touched.reserve(result.cells.size());
  for (const Cell& cell : result.cells) result.touched.push_back(char(contains(touch.cells, cell)));
  return result;
}

}  // namespace umax
