// Kinds of cells as VTK and Gmsh number them, and how their hexes come into our node order.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "embedding/hex_files/hex_mesh_formats.h"
#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

constexpr int voxel_type = 11, hexahedron_type = 12;  // of VTK

constexpr CellKind vtk_kinds[] = {
    {0, "empty cells", 0, 0},
    {1, "vertices", 0, 1},
    {2, "poly-vertices", 0, -1},
    {3, "lines", 1, 2},
    {4, "poly-lines", 1, -1},
    {5, "triangles", 2, 3},
    {6, "triangle strips", 2, -1},
    {7, "polygons", 2, -1},
    {8, "pixels", 2, 4},
    {9, "quads", 2, 4},
    {10, "tetrahedra", 3, 4},
    {voxel_type, "voxels", 3, 8},
    {hexahedron_type, "hexahedra", 3, 8},
    {13, "wedges", 3, 6},
    {14, "pyramids", 3, 5},
    {15, "pentagonal prisms", 3, 10},
    {16, "hexagonal prisms", 3, 12},
    {21, "quadratic edges", 1, 3},
    {22, "quadratic triangles", 2, 6},
    {23, "quadratic quads", 2, 8},
    {24, "quadratic tetrahedra", 3, 10},
    {25, "quadratic hexahedra (20 nodes)", 3, 20},
    {26, "quadratic wedges", 3, 15},
    {27, "quadratic pyramids", 3, 13},
    {28, "biquadratic quads", 2, 9},
    {29, "triquadratic hexahedra (27 nodes)", 3, 27},
    {30, "quadratic linear quads", 2, 6},
    {31, "quadratic linear wedges", 3, 12},
    {32, "biquadratic wedges", 3, 18},
    {33, "biquadratic hexahedra (24 nodes)", 3, 24},
    {34, "biquadratic triangles", 2, 7},
    {35, "cubic lines", 1, 4},
    {36, "quadratic polygons", 2, -1},
    {41, "convex point sets", 3, -1},
    {42, "polyhedra", 3, -1},
    {68, "Lagrange curves", 1, -1},
    {69, "Lagrange triangles", 2, -1},
    {70, "Lagrange quads", 2, -1},
    {71, "Lagrange tetrahedra", 3, -1},
    {72, "Lagrange hexahedra", 3, -1},
    {73, "Lagrange wedges", 3, -1},
    {74, "Lagrange pyramids", 3, -1},
};

constexpr CellKind gmsh_kinds[] = {
    {1, "lines", 1, 2},
    {2, "triangles", 2, 3},
    {3, "quads", 2, 4},
    {4, "tetrahedra", 3, 4},
    {5, "hexahedra", 3, 8},
    {6, "prisms", 3, 6},
    {7, "pyramids", 3, 5},
    {8, "second-order lines", 1, 3},
    {9, "second-order triangles", 2, 6},
    {10, "second-order quads", 2, 9},
    {11, "second-order tetrahedra", 3, 10},
    {12, "second-order hexahedra (27 nodes)", 3, 27},
    {13, "second-order prisms", 3, 18},
    {14, "second-order pyramids", 3, 14},
    {15, "points", 0, 1},
    {16, "second-order quads", 2, 8},
    {17, "second-order hexahedra (20 nodes)", 3, 20},
    {18, "second-order prisms", 3, 15},
    {19, "second-order pyramids", 3, 13},
    {20, "third-order triangles", 2, 9},
    {21, "third-order triangles", 2, 10},
    {26, "third-order lines", 1, 4},
    {27, "fourth-order lines", 1, 5},
    {29, "third-order tetrahedra", 3, 20},
    {30, "fourth-order tetrahedra", 3, 35},
    {36, "third-order quads", 2, 16},
    {37, "fourth-order quads", 2, 25},
    {92, "third-order hexahedra", 3, 64},
    {93, "fourth-order hexahedra", 3, 125},
};

const CellKind* find_kind(std::span<const CellKind> kinds, int type) {
  const auto found = std::find_if(kinds.begin(), kinds.end(), [&](const CellKind& kind) { return kind.type == type; });
  return found == kinds.end() ? nullptr : &*found;
}

// where our node n (x slowest, z fastest) stands in VTK's hexahedron (around the bottom, then around the top)
constexpr std::array<int, 8> place_in_hexahedron{0, 4, 3, 7, 1, 5, 2, 6};
// and in its voxel (x fastest, z slowest)
constexpr std::array<int, 8> place_in_voxel{0, 4, 2, 6, 1, 5, 3, 7};

bool is_voxel(const CellKind& kind) {
  return &kind == vtk_cell_kind(voxel_type);
}
bool is_hex(const CellKind& kind) {
  return is_voxel(kind) || (kind.dimension == 3 && kind.num_nodes == 8);
}

// VTK's numbers come as double; what is no index into `size` things is an error
long long index_below(const std::filesystem::path& path, double value, std::size_t size, const std::string& what) {
  if (value >= 0 && value < double(size) && value == std::floor(value)) return (long long)(value);
  refuse_mesh(path, what, fmt::format("{:.17g} of {}", value, size), "the file is damaged: export it again");
}

}  // namespace

const CellKind* vtk_cell_kind(int type) {
  return find_kind(vtk_kinds, type);
}
const CellKind* gmsh_cell_kind(int type) {
  return find_kind(gmsh_kinds, type);
}

void add_cell(HexFile& file, const CellKind& kind, long long id, const int* nodes) {
  if (!is_hex(kind)) {
    HexFile::Others& others = file.others[kind.name];
    if (others.count++ == 0) others.first_id = id;
    others.dimension = kind.dimension;
    return;
  }
  const auto& places = is_voxel(kind) ? place_in_voxel : place_in_hexahedron;
  auto& hex = file.hexes.emplace_back();
  for (std::size_t n = 0; n < 8; ++n) hex[n] = nodes[places[n]];
  file.hex_ids.push_back(id);
}

void add_vtk_cells(const std::filesystem::path& path, const VtkCells& cells, HexFile& file) {
  if (cells.types.size() != cells.ends.size())
    refuse_mesh(path, "has not one type for every cell",
                fmt::format("{} types and {} cells", cells.types.size(), cells.ends.size()),
                "the file is truncated or damaged: export it again");
  const std::size_t num_nodes = file.nodes.size() - std::size_t(cells.first_node);
  std::vector<int> nodes;
  long long start = 0;
  for (std::size_t c = 0; c < cells.types.size(); ++c) {
    const long long id = cells.first_cell + (long long)(c);
    const CellKind* kind = cells.types[c] >= 0 && cells.types[c] < 256 ? vtk_cell_kind(int(cells.types[c])) : nullptr;
    if (!kind)
      refuse_mesh(path, fmt::format("cell {} is of an unknown type", id), fmt::format("{:g}", cells.types[c]),
                  "write 8-node hexahedra (type 12)");
    const long long end = index_below(path, cells.ends[c], cells.nodes.size() + 1,
                                      fmt::format("the nodes of cell {} are not in the list", id));
    if (end < start || (kind->num_nodes >= 0 && end - start != kind->num_nodes))
      refuse_mesh(path, fmt::format("cell {} has a wrong number of nodes ({})", id, kind->name),
                  fmt::format("{}", end - start), "the file is damaged: export it again");
    nodes.clear();
    for (; start < end; ++start)
      nodes.push_back(
          int(cells.first_node + index_below(path, cells.nodes[std::size_t(start)], num_nodes,
                                             fmt::format("cell {} names a node that the file does not have", id))));
    add_cell(file, *kind, id, nodes.data());
  }
}

bool is_known_cell_data(const std::string& name) {
  return name == "young_factor" || name == "limit_factor";
}

void add_vtk_cell_data(const std::string& name, const std::vector<double>& values, long long first_cell,
                       HexFile& file) {
  std::vector<double>& of_hexes = file.cell_data[name];
  for (std::size_t h = of_hexes.size(); h < file.hexes.size(); ++h) {
    const long long cell = file.hex_ids[h] - first_cell;  // negative: of a piece that has no such data
    of_hexes.push_back(cell < 0 ? std::numeric_limits<double>::quiet_NaN() : values[std::size_t(cell)]);
  }
}

}  // namespace umax
