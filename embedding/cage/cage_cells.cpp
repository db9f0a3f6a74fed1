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
  Toucher(const CageGrid& grid, Touch& out) : grid_(grid), out_(out) { recent_.fill({-1, -1, -1}); }

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
    for (int i = low[0]; i <= high[0]; ++i)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int k = low[2]; k <= high[2]; ++k) test({i, j, k}, corners, plane_axis);
  }

 private:
  void test(const Cell& cell, std::array<Vector3d, 3> corners, int plane_axis) {
    for (Vector3d& corner : corners) corner -= Vector3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5);
    if (!triangle_meets_box(corners, Vector3d::Constant(0.5 - shrink))) return;
    if (plane_axis < 0) return keep(cell);
    PlanePair pair{clamped(cell), cell};
    ++pair.high[std::size_t(plane_axis)];
    pair.high = clamped(pair.high);
    out_.pairs.push_back(pair);
  }

  void keep(const Cell& cell) {
    const Cell inside = clamped(cell);
    const std::size_t slot = std::size_t(inside[0] * 73 + inside[1] * 19 + inside[2]) % recent_.size();
    if (recent_[slot] == inside) return;  // most triangles of a fine mesh fall into a cell that was just seen
    recent_[slot] = inside;
    out_.cells.push_back(inside);
  }

  Cell clamped(Cell cell) const {
    for (int axis = 0; axis < 3; ++axis)
      cell[std::size_t(axis)] = std::clamp(cell[std::size_t(axis)], 0, grid_.size[axis] - 1);
    return cell;
  }

  const CageGrid& grid_;
  Touch& out_;
  std::array<Cell, 1024> recent_;
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
