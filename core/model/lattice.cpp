#include "core/model/lattice.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/element/hexahedron.h"

namespace umax {
namespace {

using GridPoint = std::array<int, 3>;

GridPoint corner(const GridPoint& cell, int n) {
  return {cell[0] + (n >> 2 & 1), cell[1] + (n >> 1 & 1), cell[2] + (n & 1)};
}

}  // namespace

Lattice make_lattice(const Cells& cells, const Vector3d& origin, const Vector3d& cell_size) {
  std::vector<GridPoint> sorted_cells(cells.rows());
  for (Eigen::Index e = 0; e < cells.rows(); ++e) sorted_cells[e] = {cells(e, 0), cells(e, 1), cells(e, 2)};
  std::sort(sorted_cells.begin(), sorted_cells.end());

  // every grid point that some cell touches becomes a node
  std::vector<GridPoint> nodes;
  nodes.reserve(8 * sorted_cells.size());
  for (const GridPoint& cell : sorted_cells)
    for (int n = 0; n < 8; ++n) nodes.push_back(corner(cell, n));
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());

  Lattice lattice;
  lattice.origin = origin;
  lattice.cell_size = cell_size;
  lattice.rest_positions.resize(Eigen::Index(nodes.size()), 3);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      lattice.rest_positions(Eigen::Index(i), axis) = origin[axis] + nodes[i][axis] * cell_size[axis];
  lattice.cells.resize(cells.rows(), 3);
  lattice.hexes.resize(cells.rows(), 8);
  for (std::size_t e = 0; e < sorted_cells.size(); ++e) {
    for (int axis = 0; axis < 3; ++axis) lattice.cells(Eigen::Index(e), axis) = sorted_cells[e][axis];
    for (int n = 0; n < 8; ++n)
      lattice.hexes(Eigen::Index(e), n) =
          int(std::lower_bound(nodes.begin(), nodes.end(), corner(sorted_cells[e], n)) - nodes.begin());
  }
  lattice.filled_fraction = VectorXd::Ones(cells.rows());
  return lattice;
}

Lattice make_box_lattice(const Vector3i& num_cells, const Vector3d& origin, const Vector3d& cell_size) {
  Cells cells = Cells::Zero(Eigen::Index(num_cells[0]) * num_cells[1] * num_cells[2], 3);
  Eigen::Index e = 0;
  for (int i = 0; i < num_cells[0]; ++i)
    for (int j = 0; j < num_cells[1]; ++j)
      for (int k = 0; k < num_cells[2]; ++k) cells.row(e++) << i, j, k;
  return make_lattice(cells, origin, cell_size);
}

Lattice make_irregular_lattice(const Points& nodes, const Hexes& hexes) {
  Lattice lattice;
  lattice.rest_positions = nodes;
  lattice.hexes = hexes;
  lattice.filled_fraction = VectorXd::Ones(hexes.rows());
  return lattice;
}

Matrix8x3d rest_nodes(const Lattice& lattice, Eigen::Index hex) {
  Matrix8x3d nodes;
  for (int n = 0; n < 8; ++n) nodes.row(n) = lattice.rest_positions.row(lattice.hexes(hex, n));
  return nodes;
}

void validate(const Lattice& lattice) {
  const auto fail = [](const std::string& what, const std::string& value, const std::string& remedy) {
    throw Error(Fault::bad_data, {"cage", what, value, remedy});
  };
  if (lattice.num_hexes() == 0) fail("has no hexes", "0", "ask for at least one cell");
  if (lattice.filled_fraction.size() != lattice.num_hexes())
    fail("needs one filled fraction per hex", std::to_string(lattice.filled_fraction.size()), "");
  if (lattice.cells.rows() != 0 && lattice.cells.rows() != lattice.num_hexes())
    fail("needs one grid coordinate per hex", std::to_string(lattice.cells.rows()), "");
  if (lattice.is_regular() && !(lattice.cell_size.array() > 0).all())
    fail("needs the size of its cells", std::to_string(lattice.cell_size.minCoeff()), "");
  if (!lattice.rest_positions.allFinite())
    fail("has node positions that are not finite", "", "check the mesh's coordinates");
  if (lattice.hexes.minCoeff() < 0 || lattice.hexes.maxCoeff() >= lattice.num_nodes())
    fail("has a hex that names a node outside the list", std::to_string(lattice.hexes.maxCoeff()), "");
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Matrix8x3d nodes = rest_nodes(lattice, e);
    const double determinant = Matrix3d(nodes.transpose() * shape_gradients(Vector3d::Zero())).determinant();
    if (!(determinant > 0))
      fail("has a hex that is flat or inside out", "hex " + std::to_string(e), "check its node order");
  }
}

}  // namespace umax
