#include "core/model/lattice.h"

#include <set>

#include "core/base/error.h"
#include "core/element/hexahedron.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

Lattice three_cells() {
  Cells cells(3, 3);
  cells << 2, 0, 0, 0, 0, 0, 1, 0, 0;  // a row, out of order
  return make_lattice(cells, {10, 20, 30}, {1, 2, 3});
}

}  // namespace

TEST_CASE("neighbouring cells share the nodes of their face") {
  CHECK(three_cells().num_nodes() == 16);
  const Lattice box = make_box_lattice({4, 3, 2}, Vector3d::Zero(), Vector3d::Ones());
  CHECK(box.num_hexes() == 24);
  CHECK(box.num_nodes() == 5 * 4 * 3);
  std::set<int> used(box.hexes.data(), box.hexes.data() + box.hexes.size());
  CHECK(Eigen::Index(used.size()) == box.num_nodes());
}

TEST_CASE("cells that touch along an edge or a corner share just that") {
  Cells edge(2, 3), corner(2, 3), apart(2, 3);
  edge << 0, 0, 0, 1, 1, 0;
  corner << 0, 0, 0, 1, 1, 1;
  apart << 0, 0, 0, 2, 0, 0;
  CHECK(make_lattice(edge, Vector3d::Zero(), Vector3d::Ones()).num_nodes() == 14);
  CHECK(make_lattice(corner, Vector3d::Zero(), Vector3d::Ones()).num_nodes() == 15);
  CHECK(make_lattice(apart, Vector3d::Zero(), Vector3d::Ones()).num_nodes() == 16);
}

TEST_CASE("each hex has the corners of its cell, in the order of the shape functions") {
  const Lattice lattice = three_cells();
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    for (int n = 0; n < 8; ++n) {
      const Vector3d bits(n >> 2 & 1, n >> 1 & 1, n & 1);
      const Vector3d expected =
          lattice.origin + (lattice.cells.row(e).transpose().cast<double>() + bits).cwiseProduct(lattice.cell_size);
      CHECK(lattice.rest_positions.row(lattice.hexes(e, n)).transpose() == expected);
    }
}

TEST_CASE("a lattice does not depend on the order in which its cells are named") {
  Cells sorted(3, 3);
  sorted << 0, 0, 0, 1, 0, 0, 2, 0, 0;
  const Lattice a = three_cells(), b = make_lattice(sorted, {10, 20, 30}, {1, 2, 3});
  CHECK(a.rest_positions == b.rest_positions);
  CHECK(a.hexes == b.hexes);
  CHECK(a.cells == b.cells);
}

TEST_CASE("nodes are sorted with x slowest and z fastest") {
  const Lattice lattice = make_box_lattice({2, 2, 2}, Vector3d::Zero(), Vector3d::Ones());
  for (Eigen::Index i = 1; i < lattice.num_nodes(); ++i) {
    const auto weight = [&](Eigen::Index node) {
      return lattice.rest_positions.row(node).dot(Vector3d(9, 3, 1).transpose());
    };
    CHECK(weight(i) > weight(i - 1));
  }
}

TEST_CASE("a lattice that cannot be simulated is refused with what is wrong") {
  Lattice lattice = three_cells();
  CHECK_NOTHROW(validate(lattice));
  SECTION("no hexes") {
    lattice = Lattice();
  }
  SECTION("a hex names a node that is not there") {
    lattice.hexes(1, 3) = 16;
  }
  SECTION("a hex names a negative node") {
    lattice.hexes(1, 3) = -1;
  }
  SECTION("a position is not a number") {
    lattice.rest_positions(4, 1) = std::nan("");
  }
  SECTION("fractions are missing") {
    lattice.filled_fraction.resize(2);
  }
  SECTION("cells are missing") {
    lattice.cells.conservativeResize(2, 3);
  }
  SECTION("a hex is inside out") {
    const Eigen::Matrix<int, 1, 8> hex = lattice.hexes.row(0);
    lattice.hexes.row(0) << hex[1], hex[0], hex[3], hex[2], hex[5], hex[4], hex[7], hex[6];
  }
  CHECK_THROWS_AS(validate(lattice), Error);
}
