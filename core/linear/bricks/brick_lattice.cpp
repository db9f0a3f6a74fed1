#include "core/linear/bricks/brick_lattice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "core/base/parallel.h"

namespace umax {
namespace {

using Masks = std::array<std::uint16_t, brick_lines>;
using Place = std::array<int, 3>;

constexpr Place brick_size = {brick_edge, brick_edge, brick_lanes};

// occupied cells of one brick
struct CellBrick {
  Place place{};
  Masks cells{};
};

Place place_of(const Vector3i& point) {
  return {point[0] / brick_size[0], point[1] / brick_size[1], point[2] / brick_size[2]};
}

int line_of(const Vector3i& point) {
  return brick_edge * (point[0] % brick_edge) + point[1] % brick_edge;
}

// bricks of all points, without duplicates
template <class Point>
std::vector<Place> places_of(Eigen::Index count, const Point& point) {
  std::vector<Place> places;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Place place = place_of(point(i));
    if (places.empty() || places.back() != place) places.push_back(place);
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

int index_of(const std::vector<Place>& places, const Place& place) {
  const auto found = std::lower_bound(places.begin(), places.end(), place);
  return found != places.end() && *found == place ? int(found - places.begin()) : -1;
}

// does a cell of the brick touch the brick at +step?
bool reaches(const Masks& cells, const Place& step) {
  for (int line = 0; line < brick_lines; ++line) {
    const bool at_end =
        (!step[0] || line / brick_edge == brick_edge - 1) && (!step[1] || line % brick_edge == brick_edge - 1);
    if (at_end && (step[2] ? cells[line] >> (brick_lanes - 1) : cells[line])) return true;
  }
  return false;
}

template <class Visit>
void for_each_step(int low, const Visit& visit) {
  for (int di = low; di <= 1; ++di)
    for (int dj = low; dj <= 1; ++dj)
      for (int dk = 0; dk <= 1; ++dk) visit(Place{di, dj, dk});
}

Place plus(const Place& a, const Place& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

// nodes of a line: those below and above the cells of the four lines around it
std::uint16_t node_mask(const BrickLattice& lattice, int brick, int line) {
  unsigned mask = 0;
  for (int di = 0; di <= 1; ++di)
    for (int dj = 0; dj <= 1; ++dj) {
      const int i = line / brick_edge - di, j = line % brick_edge - dj;
      const int step = near_index(i < 0 ? -1 : 0, j < 0 ? -1 : 0, 0);
      const int other_line = brick_edge * (i & (brick_edge - 1)) + (j & (brick_edge - 1));
      const int other = lattice.bricks[brick].near[step];
      const unsigned cells = lattice.cell_masks[other * brick_lines + other_line];
      mask |= cells | cells << 1;
      // the brick below is the one before in its column, if any
      if (lattice.bricks[other].continues)
        mask |= unsigned(lattice.cell_masks[(other - 1) * brick_lines + other_line]) >> (brick_lanes - 1);
    }
  return std::uint16_t(mask);
}

void find_neighbours(const std::vector<Place>& places, BrickLattice& lattice) {
  for (std::size_t b = 0; b < places.size(); ++b)
    for_each_step(-1, [&](const Place& step) {
      lattice.bricks[b + 1].near[near_index(step[0], step[1], step[2])] = index_of(places, plus(places[b], step)) + 1;
    });
}

void find_columns(const std::vector<Place>& places, BrickLattice& lattice) {
  for (std::size_t b = 0; b < places.size(); ++b) {
    const bool same_column = b > 0 && places[b][0] == places[b - 1][0] && places[b][1] == places[b - 1][1];
    if (!same_column) lattice.column_starts.push_back(int(b) + 1);
    lattice.bricks[b + 1].continues = same_column && places[b][2] == places[b - 1][2] + 1;
  }
  lattice.column_starts.push_back(int(places.size()) + 1);
}

// tasks: blocks of longest_run columns side by side along x
void find_runs(const std::vector<Place>& places, BrickLattice& lattice) {
  using Key = std::array<int, 4>;  // block, j, k, i
  std::vector<std::pair<Key, int>> order;
  for (std::size_t b = 0; b < places.size(); ++b)
    order.push_back({{places[b][0] / longest_run, places[b][1], places[b][2], places[b][0]}, int(b) + 1});
  std::sort(order.begin(), order.end());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const Key& key = order[n].first;
    const Key before = n > 0 ? order[n - 1].first : Key{-1, -1, -1, -1};
    const bool same_task = key[0] == before[0] && key[1] == before[1];
    if (!same_task) lattice.task_starts.push_back(int(lattice.runs.size()));
    if (!same_task || key[2] != before[2] || key[3] != before[3] + 1)
      lattice.runs.emplace_back().first_column = key[3] % longest_run;
    BrickRun& run = lattice.runs.back();
    run.bricks[run.count++] = order[n].second;
  }
  lattice.task_starts.push_back(int(lattice.runs.size()));
}

// from the bricks that have cells, sorted by place
BrickLattice from_cell_bricks(const std::vector<CellBrick>& with_cells) {
  std::vector<Place> places;
  for (const CellBrick& brick : with_cells)
    for_each_step(0, [&](const Place& step) {
      if (step == Place{} || reaches(brick.cells, step)) places.push_back(plus(brick.place, step));
    });
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());

  BrickLattice lattice;
  lattice.bricks.resize(places.size() + 1);
  lattice.cell_masks.resize(lattice.bricks.size() * brick_lines, 0);
  lattice.node_masks.resize(lattice.bricks.size() * brick_lines, 0);
  for (std::size_t b = 0; b < places.size(); ++b) std::copy_n(places[b].begin(), 3, lattice.bricks[b + 1].place);
  find_neighbours(places, lattice);
  find_columns(places, lattice);
  find_runs(places, lattice);
  for (const CellBrick& brick : with_cells)
    std::copy(brick.cells.begin(), brick.cells.end(),
              lattice.cell_masks.begin() + (index_of(places, brick.place) + 1) * brick_lines);
  for (int b = 1; b < int(lattice.bricks.size()); ++b)
    for (int line = 0; line < brick_lines; ++line) {
      const std::uint16_t cells = lattice.cell_masks[b * brick_lines + line];
      const std::uint16_t nodes = lattice.node_masks[b * brick_lines + line] = node_mask(lattice, b, line);
      lattice.num_cells += std::popcount(cells);
      lattice.num_nodes += std::popcount(nodes);
      lattice.bricks[b].cell_lines |= std::uint64_t(cells != 0) << line;
      lattice.bricks[b].node_lines |= std::uint64_t(nodes != 0) << line;
    }
  return lattice;
}

}  // namespace

int find_brick(const BrickLattice& lattice, const Vector3i& place) {
  const Place wanted = {place[0], place[1], place[2]};
  const auto before = [](const Brick& brick, const Place& p) {
    return std::lexicographical_compare(brick.place, brick.place + 3, p.begin(), p.end());
  };
  const auto found = std::lower_bound(lattice.bricks.begin() + 1, lattice.bricks.end(), wanted, before);
  const bool equal = found != lattice.bricks.end() && std::equal(wanted.begin(), wanted.end(), found->place);
  return equal ? int(found - lattice.bricks.begin()) : 0;
}

int slot_of(const BrickLattice& lattice, const Vector3i& point) {
  const Place place = place_of(point);
  const int brick = find_brick(lattice, {place[0], place[1], place[2]});
  return (brick * brick_lines + line_of(point)) * brick_lanes + point[2] % brick_lanes;
}

int slot_near(const BrickLattice& lattice, int slot, const Vector3i& step) {
  const Vector3i at = place_in_brick(slot) + step;
  const auto outside = [](int value, int size) { return value < 0 ? -1 : value >= size ? 1 : 0; };
  const int di = outside(at[0], brick_edge), dj = outside(at[1], brick_edge), dk = outside(at[2], brick_lanes);
  int brick = lattice.bricks[slot / brick_slots].near[near_index(di, dj, std::max(dk, 0))];
  if (dk < 0) brick = lattice.bricks[brick].continues ? brick - 1 : 0;
  if (brick == 0) return -1;
  const Vector3i there(at[0] & (brick_edge - 1), at[1] & (brick_edge - 1), at[2] & (brick_lanes - 1));
  return (brick * brick_lines + line_of(there)) * brick_lanes + there[2];
}

BrickLattice make_brick_lattice(const Cells& cells, const Vector3d& cell_size) {
  const Vector3i first = cells.colwise().minCoeff().transpose();
  const auto point = [&](Eigen::Index e) -> Vector3i { return cells.row(e).transpose() - first; };
  const std::vector<Place> places = places_of(cells.rows(), point);
  std::vector<CellBrick> with_cells(places.size());
  for (std::size_t b = 0; b < places.size(); ++b) with_cells[b].place = places[b];
  int last = 0;
  for (Eigen::Index e = 0; e < cells.rows(); ++e) {
    const Vector3i cell = point(e);
    const Place place = place_of(cell);
    if (places[last] != place) last = index_of(places, place);
    with_cells[last].cells[line_of(cell)] |= std::uint16_t(1u << cell[2] % brick_lanes);
  }
  BrickLattice lattice = from_cell_bricks(with_cells);
  lattice.first_cell = first;
  lattice.cell_size = cell_size;
  return lattice;
}

BrickLattice coarsen(const BrickLattice& fine, const Vector3i& factor) {
  const auto coarse_place = [&](const Brick& brick) -> Place {
    return {brick.place[0] / factor[0], brick.place[1] / factor[1], brick.place[2] / factor[2]};
  };
  std::vector<Place> places;
  for (std::size_t b = 1; b < fine.bricks.size(); ++b)
    if (fine.bricks[b].cell_lines) places.push_back(coarse_place(fine.bricks[b]));
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());

  std::vector<CellBrick> with_cells(places.size());
  for (std::size_t b = 0; b < places.size(); ++b) with_cells[b].place = places[b];
  for (std::size_t b = 1; b < fine.bricks.size(); ++b) {
    if (!fine.bricks[b].cell_lines) continue;
    CellBrick& coarse = with_cells[index_of(places, coarse_place(fine.bricks[b]))];
    for (int slot = 0; slot < brick_slots; ++slot) {
      const int line = slot / brick_lanes;
      if (!(fine.cell_masks[b * brick_lines + line] >> slot % brick_lanes & 1)) continue;
      const Eigen::Map<const Vector3i> size(brick_size.data()), place(fine.bricks[b].place);
      const Vector3i cell = (size.cwiseProduct(place) + place_in_brick(slot)).cwiseQuotient(factor);
      coarse.cells[line_of(cell)] |= std::uint16_t(1u << cell[2] % brick_lanes);
    }
  }
  BrickLattice lattice = from_cell_bricks(with_cells);
  lattice.cell_size = fine.cell_size.cwiseProduct(factor.cast<double>());
  return lattice;
}

std::vector<int> cell_slots(const BrickLattice& lattice, const Cells& cells) {
  std::vector<int> slots(cells.rows());
  for (Eigen::Index e = 0; e < cells.rows(); ++e)
    slots[e] = slot_of(lattice, cells.row(e).transpose() - lattice.first_cell);
  return slots;
}

std::vector<int> node_slots(const BrickLattice& lattice, const Cells& cells, const Hexes& hexes,
                            Eigen::Index num_nodes) {
  std::vector<int> slots(num_nodes, -1);
  for (Eigen::Index e = 0; e < cells.rows(); ++e)
    for (int n = 0; n < 8; ++n)
      if (slots[hexes(e, n)] < 0)
        slots[hexes(e, n)] = slot_of(lattice, cells.row(e).transpose() - lattice.first_cell + corner(n));
  return slots;
}

double sum_over_tasks(int num_tasks, int grain, double (*body)(const void* context, int task), const void* context) {
  std::vector<double> sums(num_tasks, 0.0);
  parallel_blocks(num_tasks, grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index task = begin; task < end; ++task) sums[task] = body(context, int(task));
  });
  double total = 0;
  for (const double sum : sums) total += sum;
  return total;
}

}  // namespace umax
