#include "embedding/cage/voxelize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "embedding/cage/cage_cells.h"
#include "embedding/cage/cell_table.h"
#include "embedding/cage/filled_fraction.h"
#include "embedding/surface/hex_faces.h"
#include "embedding/surface/topology.h"

namespace umax {
namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& remedy) {
  throw Error(Fault::bad_data, {"cage", what, value, remedy});
}

struct Shape {
  Vector3d low{0, 0, 0}, high{0, 0, 0};  // [m]
  double volume = 0, area = 0;           // [m^3], [m^2]
  Vector3d extent() const { return high - low; }
  // [-] how many cubes of edge h touch or fill it, to a factor of about 1.5
  double estimated_cells(double h) const { return std::max(volume / (h * h * h) + 0.9 * area / (h * h), 1.0); }
};

// largest edge that is estimated to give at least that many cells
double estimated_edge(const Shape& shape, double num_cells) {
  double low = 1e-9 * shape.extent().maxCoeff(), high = 4 * shape.extent().maxCoeff();
  for (int i = 0; i < 100; ++i) {
    const double middle = std::sqrt(low * high);
    (shape.estimated_cells(middle) > num_cells ? low : high) = middle;
  }
  return high;
}

void require_affordable(double num_cells, const CageOptions& options) {
  if (num_cells <= double(options.max_cells)) return;
  refuse(fmt::format("would have more than {} cells", options.max_cells), fmt::format("about {:.3g}", num_cells),
         "ask for fewer or larger cells");
}

// cubes, as few as cover the box, centred on it
CageGrid cube_grid(const Shape& shape, double edge) {
  CageGrid grid;
  grid.cell_size.setConstant(edge);
  for (int axis = 0; axis < 3; ++axis)
    grid.size[axis] = std::max(1, int(std::ceil(shape.extent()[axis] / edge - face_tolerance)));
  grid.origin = 0.5 * (shape.low + shape.high) - 0.5 * edge * grid.size.cast<double>();
  return grid;
}

// the box cut evenly; along an axis on which the mesh has no extent the cells get the largest edge of the others
CageGrid box_grid(const Shape& shape, const Vector3i& size) {
  if (size.minCoeff() < 1)
    refuse("needs at least one cell along every axis", fmt::format("[{}, {}, {}]", size[0], size[1], size[2]),
           "give a grid such as [14, 2, 2]");
  CageGrid grid{shape.low, shape.extent().cwiseQuotient(size.cast<double>()), size};
  const double largest = grid.cell_size.maxCoeff();
  for (int axis = 0; axis < 3; ++axis)
    if (!(grid.cell_size[axis] > 1e-9 * largest)) {
      grid.cell_size[axis] = largest;
      grid.origin[axis] -= 0.5 * largest * size[axis];
    }
  return grid;
}

CageCells whole_box(const CageGrid& grid, const CageCells& solid_cells) {
  CageCells all;
  for (int i = 0; i < grid.size[0]; ++i)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int k = 0; k < grid.size[2]; ++k) {
        const auto found = std::lower_bound(solid_cells.cells.begin(), solid_cells.cells.end(), Cell{i, j, k});
        const bool filled = found != solid_cells.cells.end() && *found == Cell{i, j, k};
        all.cells.push_back({i, j, k});
        // a cell outside is sampled like a touched one and comes out empty
        all.touched.push_back(char(!filled || solid_cells.touched[std::size_t(found - solid_cells.cells.begin())]));
      }
  return all;
}

class CageSearch {
 public:
  CageSearch(const TriangleMesh& mesh, const CageOptions& options, const Shape& shape, const Solid& solid)
      : mesh_(mesh), options_(options), shape_(shape), solid_(solid) {}

  CageCells cells(const CageGrid& grid) const {
    if (options_.whole_box) require_affordable(grid.size.cast<double>().prod(), options_);
    CageCells cells = cage_cells(solid_, mesh_.positions, mesh_.triangles, grid);
    require_affordable(double(cells.cells.size()), options_);
    return options_.whole_box ? whole_box(grid, cells) : cells;
  }

  /// Edge of the cubes whose number comes nearest to the wanted one; among equals the smallest edge that was tried.
  double edge_for(int wanted) const {
    double high = estimated_edge(shape_, wanted), low = high;
    try_edge(high, wanted);
    while (count_ > wanted) try_edge(high *= 1.2, wanted);
    low = high / 1.2;
    try_edge(low, wanted);
    while (count_ <= wanted && low > 0.05 * high) try_edge(low /= 1.2, wanted);

    // the number falls in steps as the edge grows: close in on the step past the wanted number
    const double precision = wanted > 20000 ? 1e-4 : 1e-7;
    while (high - low > precision * high) {
      const double middle = 0.5 * (low + high);
      try_edge(middle, wanted);
      (count_ > wanted ? low : high) = middle;
    }
    try_exact_divisions(high, wanted);
    return best_edge_;
  }

 private:
  // edges that divide an extent of the box exactly make the tightest cages
  void try_exact_divisions(double edge, int wanted) const {
    for (int axis = 0; axis < 3; ++axis) {
      const double parts = std::round(shape_.extent()[axis] / edge);
      if (parts >= 1 && std::abs(shape_.extent()[axis] / parts - edge) < 1e-6 * edge)
        try_edge(shape_.extent()[axis] / parts, wanted);
    }
  }

  void try_edge(double edge, int wanted) const {
    const CageGrid grid = cube_grid(shape_, edge);
    count_ = options_.whole_box ? (long long)(grid.size.cast<double>().prod())
                                : (long long)(cage_cells(solid_, mesh_.positions, mesh_.triangles, grid).cells.size());
    const long long miss = std::abs(count_ - wanted);
    if (best_edge_ > 0 && (miss > best_miss_ || (miss == best_miss_ && edge >= best_edge_))) return;
    best_miss_ = miss;
    best_edge_ = edge;
  }

  const TriangleMesh& mesh_;
  const CageOptions& options_;
  const Shape& shape_;
  const Solid& solid_;
  mutable long long count_ = 0, best_miss_ = 0;
  mutable double best_edge_ = 0;
};

Shape measure(const TriangleMesh& mesh) {
  if (mesh.num_vertices() == 0 || mesh.num_triangles() == 0)
    refuse("needs a mesh with triangles", "none", "give another mesh");
  Shape shape;
  shape.low = mesh.positions.colwise().minCoeff();
  shape.high = mesh.positions.colwise().maxCoeff();
  if (!(shape.extent().maxCoeff() > 0) || !shape.extent().allFinite())
    refuse("needs a mesh with an extent", fmt::format("{:g} m", shape.extent().maxCoeff()),
           "all its vertices lie in one point, or are not finite");
  return shape;
}

// [m] largest edge of the cells to come; checks what the user asked for
double intended_edge(const Shape& shape, const CageOptions& options) {
  if (const int* wanted = std::get_if<int>(&options.size)) {
    if (*wanted < 1) refuse("needs at least one cell", std::to_string(*wanted), "give a number such as 365");
    require_affordable(*wanted, options);
    return estimated_edge(shape, *wanted);
  }
  if (const double* edge = std::get_if<double>(&options.size)) {
    if (!(*edge > 0) || !std::isfinite(*edge))
      refuse("needs a positive cell size", fmt::format("{:g} m", *edge), "give a length such as \"10 cm\"");
    require_affordable(shape.volume / (*edge * *edge * *edge), options);
    require_affordable(0.4 * shape.estimated_cells(*edge), options);
    require_affordable(shape.extent().maxCoeff() / *edge, options);
    return *edge;
  }
  const Vector3i& size = std::get<Vector3i>(options.size);
  const CageGrid grid = box_grid(shape, size);
  const double largest = grid.cell_size.maxCoeff();
  require_affordable(options.whole_box ? size.cast<double>().prod() : shape.volume / grid.cell_size.prod(), options);
  require_affordable(0.4 * shape.estimated_cells(largest), options);
  require_affordable(size.maxCoeff(), options);
  return largest;
}

// [m] eight voxels of the level set to a cell's edge; fewer, down to four, where there are many cells
double level_set_voxel(const Shape& shape, double edge) {
  constexpr double many_band_voxels = 4e6;
  const double fine = std::min(edge / 8, shape.extent().maxCoeff() / 64);
  return std::max(fine, std::min(edge / 4, std::sqrt(8 * shape.area / many_band_voxels)));
}

void cover_every_vertex(const TriangleMesh& mesh, const CageGrid& grid, CageCells& cells) {
  Cells table_cells(Eigen::Index(cells.cells.size()), 3);
  for (std::size_t e = 0; e < cells.cells.size(); ++e)
    table_cells.row(Eigen::Index(e)) = Eigen::Map<const Eigen::RowVector3i>(cells.cells[e].data());
  const CellTable table(table_cells);
  std::vector<Cell> missing;
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v) {
    const Vector3d s = (mesh.positions.row(v).transpose() - grid.origin).cwiseQuotient(grid.cell_size);
    if (table.find(s) >= 0) continue;
    Cell cell;
    for (int axis = 0; axis < 3; ++axis)
      cell[std::size_t(axis)] = std::clamp(int(std::floor(s[axis])), 0, grid.size[axis] - 1);
    missing.push_back(cell);
  }
  if (missing.empty()) return;

  // vertices of no triangle, and needles thinner than the tests can see
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  for (const Cell& cell : missing) {
    const auto place = std::lower_bound(cells.cells.begin(), cells.cells.end(), cell);
    cells.touched.insert(cells.touched.begin() + (place - cells.cells.begin()), 1);
    cells.cells.insert(place, cell);
  }
}

int count_sets(DisjointSets& sets, Eigen::Index size) {
  int roots = 0;
  for (int i = 0; i < int(size); ++i) roots += sets.root(i) == i;
  return roots;
}

// [hexes] of the largest set that share nodes
Eigen::Index largest_piece(const Lattice& lattice, DisjointSets& nodes) {
  std::vector<Eigen::Index> sizes(std::size_t(lattice.num_nodes()), 0);
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) ++sizes[std::size_t(nodes.root(lattice.hexes(e, 0)))];
  return *std::max_element(sizes.begin(), sizes.end());
}

// merges hexes that share a face
void merge_neighbours(const Lattice& lattice, DisjointSets& hexes) {
  if (!lattice.is_regular()) {
    for_each_face(hex_faces(lattice.hexes), [&](auto first, auto last) {
      for (auto face = first + 1; face < last; ++face) hexes.merge(first->hex, face->hex);
    });
    return;
  }
  const CellTable table(lattice.cells);
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    for (int axis = 0; axis < 3; ++axis) {
      Vector3i next = lattice.cells.row(e);
      ++next[axis];
      if (const int other = table.find(next[0], next[1], next[2]); other >= 0) hexes.merge(int(e), other);
    }
}

}  // namespace

void report_connections(const Lattice& lattice, CageReport& report) {
  DisjointSets nodes(std::size_t(lattice.num_nodes())), hexes(std::size_t(lattice.num_hexes()));
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    for (int n = 1; n < 8; ++n) nodes.merge(lattice.hexes(e, 0), lattice.hexes(e, n));
  merge_neighbours(lattice, hexes);
  report.num_islands = count_sets(nodes, lattice.num_nodes());
  report.num_loose_parts = count_sets(hexes, lattice.num_hexes());
  if (report.num_islands > 1)
    report.notes.push_back(fmt::format(
        "the cage is in {} pieces that share no node, the largest of {} of {} hexes; each falls by itself: take larger "
        "(fewer) cells or join the mesh's parts to hold them together, and remove what does not belong to it",
        report.num_islands, largest_piece(lattice, nodes), lattice.num_hexes()));
}

Lattice voxelize(const TriangleMesh& mesh, const CageOptions& options, CageReport* report) {
  Shape shape = measure(mesh);
  ClosedSurface surface = close_surface(mesh);
  shape.volume = std::abs(surface.volume);
  shape.area = surface_area(mesh);

  const double edge = intended_edge(shape, options);
  const Solid solid = make_solid(mesh, std::move(surface), level_set_voxel(shape, edge));
  const CageSearch search(mesh, options, shape, solid);
  CageGrid grid;
  if (const int* wanted = std::get_if<int>(&options.size))
    grid = cube_grid(shape, search.edge_for(*wanted));
  else if (const double* cell_edge = std::get_if<double>(&options.size))
    grid = cube_grid(shape, *cell_edge);
  else
    grid = box_grid(shape, std::get<Vector3i>(options.size));

  CageCells cells = search.cells(grid);
  cover_every_vertex(mesh, grid, cells);
  Cells coordinates(Eigen::Index(cells.cells.size()), 3);
  for (std::size_t e = 0; e < cells.cells.size(); ++e)
    coordinates.row(Eigen::Index(e)) = Eigen::Map<const Eigen::RowVector3i>(cells.cells[e].data());
  Lattice lattice = make_lattice(coordinates, grid.origin, grid.cell_size);
  lattice.filled_fraction = filled_fractions(solid, grid, cells);

  if (report) {
    *report = {};
    report->method = solid.method;
    report->notes = solid.notes;
    report->mesh_volume = solid.mesh_volume;
    report->level_set_volume = solid.level_set_volume;
    report->filled_volume = lattice.filled_fraction.sum() * grid.cell_size.prod();
    report_connections(lattice, *report);
  }
  return lattice;
}

}  // namespace umax
