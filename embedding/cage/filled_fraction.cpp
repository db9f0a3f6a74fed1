#include "embedding/cage/filled_fraction.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

// adds the length [cells] of every inside stretch to the cells of its column
VectorXd fractions_by_winding(const Solid& solid, const CageGrid& grid, const CageCells& cells) {
  const double num_columns = double(grid.size[0]) * grid.size[1];
  int lines_per_cell = num_columns > 1e5 ? 8 : 16;
  LineGrid lines;
  lines.spacing = grid.cell_size.head<2>() / lines_per_cell;
  for (; lines_per_cell > 1 && num_crossings(solid.surface, lines) > most_crossings; lines_per_cell /= 2)
    lines.spacing *= 2;
  lines.origin = grid.origin.head<2>() + 0.5 * lines.spacing;
  lines.size = grid.size.head<2>() * lines_per_cell;
  lines.group = lines_per_cell;

  VectorXd fractions = VectorXd::Zero(Eigen::Index(cells.cells.size()));
  const double share = 1.0 / (lines_per_cell * lines_per_cell);
  visit_inside(solid.surface, lines, [&](int line_i, int line_j, double z0, double z1) {
    const double low = (z0 - grid.origin[2]) / grid.cell_size[2], high = (z1 - grid.origin[2]) / grid.cell_size[2];
    const int i = line_i / lines_per_cell, j = line_j / lines_per_cell;
    const int k0 = std::clamp(int(std::floor(low)), 0, grid.size[2] - 1);
    auto cell = std::lower_bound(cells.cells.begin(), cells.cells.end(), Cell{i, j, k0});
    for (; cell != cells.cells.end() && (*cell)[0] == i && (*cell)[1] == j && (*cell)[2] < high; ++cell) {
      const double k = (*cell)[2];
      fractions[cell - cells.cells.begin()] += share * std::max(0.0, std::min(high, k + 1) - std::max(low, k));
    }
  });
  return fractions;
}

VectorXd fractions_by_level_set(const Solid& solid, const CageGrid& grid, const CageCells& cells) {
  constexpr int samples = 8, per_cell = samples * samples * samples;
  const Vector3d step = grid.cell_size / samples;
  VectorXd fractions = VectorXd::Ones(Eigen::Index(cells.cells.size()));
  constexpr std::size_t block_size = 4096;  // cells whose samples are held at once
  std::vector<std::size_t> touched;
  for (std::size_t e = 0; e < cells.cells.size(); ++e)
    if (cells.touched[e]) touched.push_back(e);

  for (std::size_t first = 0; first < touched.size(); first += block_size) {
    const std::size_t last = std::min(touched.size(), first + block_size);
    Points points(Eigen::Index(last - first) * per_cell, 3);
    Eigen::Index next = 0;
    for (std::size_t t = first; t < last; ++t) {
      const Cell& cell = cells.cells[touched[t]];
      const Vector3d corner = grid.origin + Vector3d(cell[0], cell[1], cell[2]).cwiseProduct(grid.cell_size);
      for (int i = 0; i < samples; ++i)
        for (int j = 0; j < samples; ++j)
          for (int k = 0; k < samples; ++k)
            points.row(next++) = corner + Vector3d(i + 0.5, j + 0.5, k + 0.5).cwiseProduct(step);
    }
    const std::vector<float> distances = solid.level_set->sample(points);
    for (std::size_t t = first; t < last; ++t) {
      // a sample near the surface counts for the part of its own little cell that is inside
      double sum = 0;
      for (int s = 0; s < per_cell; ++s)
        sum += std::clamp(0.5 - double(distances[(t - first) * per_cell + std::size_t(s)]) / step.mean(), 0.0, 1.0);
      fractions[Eigen::Index(touched[t])] = sum / per_cell;
    }
  }
  return fractions;
}

}  // namespace

VectorXd filled_fractions(const Solid& solid, const CageGrid& grid, const CageCells& cells) {
  if (solid.level_set) return fractions_by_level_set(solid, grid, cells);
  return fractions_by_winding(solid, grid, cells).cwiseMin(1.0);
}

}  // namespace umax
