// Factors of hexes from OpenVDB grids and from painted surfaces.
#include "embedding/maps/factor_map.h"

#include <cmath>
#include <limits>

#include "core/element/hexahedron.h"
#include "embedding/surface/distance_grid.h"
#include "tests/embedding/meshes.h"
#include "tests/embedding/vdb_file.h"
#include "tests/support/catch.h"
#include "tests/support/distorted.h"
#include "tests/support/failure.h"

using namespace umax;
using namespace umax::testing;
using umax::test::contains;
using umax::test::Failure;
using umax::test::failure_of;
using umax::test::VdbContent;

namespace {

VdbGrid number_grid(const VdbContent& content) {
  return VdbGrid(vdb_file("grid.vdb", {content}), "", VdbGrid::Kind::number);
}

/// 4 x 4 x 4 hexes in [-0.4, 0.4]^3.
Lattice cube_lattice() {
  return make_box_lattice({4, 4, 4}, Vector3d::Constant(-0.4), Vector3d::Constant(0.2));
}
Vector3d centre_of(const Lattice& lattice, Eigen::Index hex) {
  return rest_nodes(lattice, hex).colwise().mean().transpose();
}

const Eigen::Affine3d as_it_is = Eigen::Affine3d::Identity();

/// The box [-0.4, 0.4]^3 in triangles, painted by color(position).
template <class ColorAt>
TriangleMesh painted_cube(ColorAt color) {
  TriangleMesh mesh = make_box(Vector3d::Constant(0.8));
  mesh.colors.resize(mesh.num_vertices(), 3);
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v)
    mesh.colors.row(v) = Vector3d(color(Vector3d(mesh.positions.row(v).transpose()))).transpose();
  return mesh;
}
/// Black at x = -0.4, white at x = 0.4.
Vector3d grey_along_x(const Vector3d& p) {
  return Vector3d::Constant(std::clamp((p.x() + 0.4) / 0.8, 0.0, 1.0));
}

}  // namespace

TEST_CASE("a hex takes the mean of the grid's numbers over its volume") {
  const auto field = [](const Vector3d& p) { return 3 + 2 * p.x() - p.y() + 0.5 * p.z(); };
  const VdbGrid grid = number_grid({.number = field, .voxel = 0.04, .first = {-12, -12, -12}, .last = {12, 12, 12}});
  const Lattice lattice = cube_lattice();
  const HexFactors found = factors_from_grid(grid, as_it_is, lattice, nullptr, {});
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    CHECK(found.factors[e] == Approx(field(centre_of(lattice, e))).epsilon(1e-6));
  CHECK(found.num_outside == 0);
  CHECK(found.num_clamped == 0);
  CHECK(found.least == Approx(found.factors.minCoeff()));
  CHECK(found.largest == Approx(found.factors.maxCoeff()));
}

TEST_CASE("the mean of a hex that is no box weighs by volume") {
  const Lattice lattice = test::distorted_lattice(cube_lattice(), 0.3);
  const VdbGrid grid = number_grid({.number = [](const Vector3d& p) { return 2 + p.x(); },
                                    .voxel = 0.02,
                                    .first = {-32, -32, -32},
                                    .last = {32, 32, 32}});
  const HexFactors found = factors_from_grid(grid, as_it_is, lattice, nullptr, {});
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    // the exact mean by Gauss quadrature
    const Matrix8x3d nodes = rest_nodes(lattice, e);
    double sum = 0, volume = 0;
    for (const Vector3d& s : quadrature_points()) {
      const double weight = Matrix3d(nodes.transpose() * shape_gradients(s)).determinant();
      sum += weight * (2 + (nodes.transpose() * shape_functions(s)).x());
      volume += weight;
    }
    CHECK(found.factors[e] == Approx(sum / volume).epsilon(5e-4));
  }
}

TEST_CASE("only active voxels speak, and hexes without one are outside") {
  // active from x = -0.42 to 0.02: half of the hexes, and a strip of those that follow
  const VdbGrid grid = number_grid(
      {.number = [](const Vector3d&) { return 3.0; }, .voxel = 0.04, .first = {-10, -12, -12}, .last = {0, 12, 12}});
  const Lattice lattice = cube_lattice();
  const HexFactors found = factors_from_grid(grid, as_it_is, lattice, nullptr, {});
  int num_outside = 0;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const bool reached = centre_of(lattice, e).x() < 0;
    CHECK(found.factors[e] == Approx(reached ? 3 : 1).epsilon(1e-12));
    num_outside += !reached;
  }
  CHECK(num_outside == 32);
  CHECK(found.num_outside == 32);
  CHECK(grid.box().min().isApprox(Vector3d(-0.42, -0.5, -0.5), 1e-6));
  CHECK(grid.box().max().isApprox(Vector3d(0.02, 0.5, 0.5), 1e-6));
}

TEST_CASE("what a grid says outside the solid does not count") {
  const TriangleMesh ball = make_sphere(0.37, 4);
  Lattice lattice = cube_lattice();
  lattice.filled_fraction.setConstant(0.5);
  const VdbGrid grid = number_grid({.number = [](const Vector3d& p) { return p.norm() < 0.38 ? 0.5 : 100; },
                                    .voxel = 0.01,
                                    .first = {-45, -45, -45},
                                    .last = {45, 45, 45}});
  const SampledDistance distance = make_distance_grid(ball);
  const HexFactors of_solid = factors_from_grid(grid, as_it_is, lattice, &distance, {});
  const HexFactors of_all = factors_from_grid(grid, as_it_is, lattice, nullptr, {});
  int num_cut = 0;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const bool has_solid = centre_of(lattice, e).norm() < 0.4;
    if (!has_solid) continue;
    CHECK(of_solid.factors[e] == Approx(0.5).epsilon(1e-6));
    num_cut += of_all.factors[e] > 5;
  }
  CHECK(num_cut >= 24);
}

TEST_CASE("a grid is read in its own coordinates, wherever the body stands") {
  const auto field = [](const Vector3d& p) { return 2 + p.x() + 0.3 * p.y() - 0.4 * p.z(); };
  const VdbGrid grid = number_grid({.number = field, .voxel = 0.04, .first = {-14, -14, -14}, .last = {14, 14, 14}});
  Eigen::Affine3d placed = Eigen::Affine3d::Identity();
  placed.prescale(3).prerotate(test::Random(4).rotation()).pretranslate(Vector3d(5, 7, -2));
  const Lattice own = cube_lattice();
  const Lattice lattice = make_irregular_lattice(
      (own.rest_positions * placed.linear().transpose()).rowwise() + placed.translation().transpose(), own.hexes);
  const HexFactors found = factors_from_grid(grid, placed.inverse(), lattice, nullptr, {});
  for (Eigen::Index e = 0; e < own.num_hexes(); ++e)
    CHECK(found.factors[e] == Approx(field(centre_of(own, e))).epsilon(1e-6));
}

TEST_CASE("numbers beyond 0.01 and 1000 are clamped and counted, with a range, those beyond 0 and 1") {
  const auto field = [](const Vector3d& p) { return p.x() < -0.2 ? 0.0 : p.x() > 0.2 ? 5e6 : 0.25; };
  const VdbGrid grid = number_grid({.number = field, .voxel = 0.01, .first = {-45, -45, -45}, .last = {45, 45, 45}});
  const Lattice lattice = cube_lattice();
  const HexFactors plain = factors_from_grid(grid, as_it_is, lattice, nullptr, {});
  const HexFactors ranged = factors_from_grid(grid, as_it_is, lattice, nullptr, FactorRange{10, 2});
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const double x = centre_of(lattice, e).x();
    CHECK(plain.factors[e] == Approx(x < -0.2 ? 0.01 : x > 0.2 ? 1000 : 0.25));
    CHECK(ranged.factors[e] == Approx(x < -0.2 ? 10 : x > 0.2 ? 2 : 8));
  }
  CHECK(plain.num_clamped == 32);
  CHECK(ranged.num_clamped == 16);
  CHECK(plain.least == 0);
  CHECK(plain.largest == Approx(5e6));
}

TEST_CASE("a hex takes the direction that prevails in the grid, whatever the vectors' signs and lengths") {
  // along a circle about z; every second voxel points backwards and is longer
  const auto around = [](const Vector3d& p) {
    const int parity = int(std::lround(p.sum() / 0.02)) & 1;
    return Vector3d((parity ? -7 : 1) * Vector3d(-p.y(), p.x(), 0));
  };
  const VdbGrid grid(
      vdb_file("around.vdb",
               {{.name = "fibre", .direction = around, .voxel = 0.02, .first = {-22, -22, -22}, .last = {22, 22, 0}}}),
      "", VdbGrid::Kind::direction);
  const Lattice lattice = make_box_lattice({4, 4, 4}, {0.1, 0.1, -0.4}, {0.07, 0.07, 0.2});
  const HexDirections found = directions_from_grid(grid, as_it_is, lattice, nullptr, {0, 3, 0});
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Vector3d centre = centre_of(lattice, e), direction = found.directions.row(e).transpose();
    CHECK(direction.norm() == Approx(1));
    const bool reached = centre.z() < 0;
    const Vector3d expected = reached ? Vector3d(-centre.y(), centre.x(), 0).normalized() : Vector3d(0, 1, 0);
    CHECK(std::abs(direction.dot(expected)) > (reached ? 0.995 : 1 - 1e-12));
    CHECK(direction.y() > 0);  // on the uniform direction's side
  }
  CHECK(found.num_outside == 32);

  // turned with the body
  Eigen::Affine3d placed = Eigen::Affine3d::Identity();
  placed.prescale(3).prerotate(test::Random(4).rotation()).pretranslate(Vector3d(5, 7, -2));
  const Lattice turned = make_irregular_lattice(
      (lattice.rest_positions * placed.linear().transpose()).rowwise() + placed.translation().transpose(),
      lattice.hexes);
  const HexDirections there = directions_from_grid(grid, placed.inverse(), turned, nullptr, {0, 3, 0});
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    if (centre_of(lattice, e).z() > 0) continue;
    const Vector3d expected = placed.rotation() * Vector3d(found.directions.row(e).transpose());
    CHECK(std::abs(there.directions.row(e).dot(expected.transpose())) == Approx(1).epsilon(1e-6));
  }

  // two directions that are as strong as each other, and none: the uniform one stays
  const auto undecided = [](const Vector3d& p) {
    return p.x() < 0 ? Vector3d::Zero().eval() : Vector3d(int(std::lround(p.y() / 0.02)) & 1, 0, 0).eval();
  };
  const VdbGrid half(
      vdb_file("half.vdb", {{.direction = undecided, .voxel = 0.02, .first = {-22, -22, -22}, .last = {22, 22, 22}}}),
      "", VdbGrid::Kind::direction);
  const HexDirections along_x = directions_from_grid(half, as_it_is, cube_lattice(), nullptr, {0, 0, 1});
  CHECK(along_x.num_outside == 32);
  CHECK(along_x.directions.row(0) == Eigen::RowVector3d(0, 0, 1));
  CHECK(along_x.directions.row(63).isApprox(Eigen::RowVector3d(1, 0, 0)));
}

TEST_CASE("a grid that lies beside the body is refused with both boxes") {
  const VdbGrid grid =
      number_grid({.number = [](const Vector3d&) { return 1.0; }, .first = {100, 100, 100}, .last = {104, 104, 104}});
  const Failure away = failure_of([&] { factors_from_grid(grid, as_it_is, cube_lattice(), nullptr, std::nullopt); });
  CHECK(away.code == 65);
  CHECK(contains(away.message, "reaches no hex of the body, got a grid from (4.975, 4.975, 4.975) to (5.225"));
  CHECK(contains(away.message, "a cage from (-0.4, -0.4, -0.4) to (0.4, 0.4, 0.4)"));
}

TEST_CASE("a hex takes the mean of the paint on its part of the surface, by area") {
  const TriangleMesh cube = painted_cube(grey_along_x);
  const Lattice lattice = cube_lattice();
  const HexFactors found = factors_from_paint(cube, cube, lattice, {1, 3});
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Eigen::RowVector3i cell = lattice.cells.row(e);
    const auto at_end = [&](int axis) { return cell[axis] == 0 || cell[axis] == 3; };
    const int num_sides = at_end(1) + at_end(2);
    if (num_sides + at_end(0) == 0) continue;
    // faces along x have the grey of their middle, those at the ends are black or white
    const double along = (cell[0] + 0.5) / 4, end = cell[0] == 0 ? 0 : 1;
    const double grey = (num_sides * along + at_end(0) * end) / (num_sides + at_end(0));
    CHECK(found.factors[e] == Approx(1 + 2 * grey).margin(0.02));
  }
  CHECK(found.num_outside == 0);
}

TEST_CASE("a colour counts as its luminance") {
  const Lattice lattice = cube_lattice();
  for (const auto& [color, luminance] : {std::pair(Vector3d(1, 0, 0), 0.2126),
                                         {Vector3d(0, 1, 0), 0.7152},
                                         {Vector3d(0, 0, 1), 0.0722},
                                         {Vector3d(1, 1, 1), 1.0}}) {
    const TriangleMesh cube = painted_cube([&, c = color](const Vector3d&) { return c; });
    const HexFactors found = factors_from_paint(cube, cube, lattice, {0.5, 100.5});
    CHECK(found.factors.minCoeff() == Approx(0.5 + 100 * luminance).epsilon(1e-9));
    // the eight hexes within have it too
    CHECK(found.factors.maxCoeff() == Approx(0.5 + 100 * luminance).epsilon(1e-9));
    CHECK(found.num_outside + found.num_clamped == 0);
  }
  const TriangleMesh bright = painted_cube([](const Vector3d&) { return Vector3d(2, 2, 2); });
  const HexFactors found = factors_from_paint(bright, bright, lattice, {0.5, 4});
  CHECK(found.num_clamped == 56);
  CHECK(found.factors == VectorXd::Constant(64, 4));
}

TEST_CASE("hexes within a painted surface take what surrounds them") {
  const Lattice lattice = make_box_lattice({8, 8, 8}, Vector3d::Constant(-0.4), Vector3d::Constant(0.1));
  const TriangleMesh cube = painted_cube([](const Vector3d& p) {
    return Vector3d::Constant(p.x() > 1e-6 ? 1 : p.x() < -1e-6 ? 0 : 0.5);
  });
  const HexFactors found = factors_from_paint(cube, cube, lattice, {0.1, 1});
  const auto at = [&](int i, int j, int k) { return found.factors[(i * 8 + j) * 8 + k]; };
  // the second layer under the black and the white end
  CHECK(at(1, 3, 4) < 0.25);
  CHECK(at(6, 3, 4) > 0.85);
  CHECK(at(3, 3, 3) + at(4, 3, 3) == Approx(1.1).margin(0.02));  // by symmetry
  CHECK(found.num_outside == 0);
}

TEST_CASE("paint works on hexes of any shape") {
  const Lattice lattice = test::distorted_lattice(cube_lattice(), 0.3);
  const TriangleMesh ball = [] {
    TriangleMesh mesh = make_sphere(0.25, 4);
    mesh.colors = Points::Constant(mesh.num_vertices(), 3, 0.5);
    return mesh;
  }();
  const HexFactors found = factors_from_paint(ball, ball, lattice, {2, 4});
  CHECK(found.factors.minCoeff() == Approx(3).epsilon(1e-12));
  CHECK(found.factors.maxCoeff() == Approx(3).epsilon(1e-12));
}

TEST_CASE("paint that lies beside the cage by rounding counts") {
  const TriangleMesh cube = painted_cube([](const Vector3d&) { return Vector3d::Constant(0.5); });
  TriangleMesh rounded = cube;
  rounded.positions *= 1 + 1e-7;
  const HexFactors found = factors_from_paint(rounded, cube, cube_lattice(), {2, 4});
  CHECK(found.factors.isApprox(VectorXd::Constant(64, 3)));
  CHECK(found.num_outside == 0);
}

TEST_CASE("where the body has a surface and the map has none, the body's own value stays") {
  const TriangleMesh cube = make_box(Vector3d::Constant(0.8));
  TriangleMesh patch = painted_cube([](const Vector3d&) { return Vector3d::Zero(); });
  patch.positions.col(0) = (patch.positions.col(0).array() < 0).select(patch.positions.col(0), -0.01);
  const HexFactors found = factors_from_paint(patch, cube, cube_lattice(), {0.2, 1});
  const Lattice lattice = cube_lattice();
  int num_outside = 0;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Eigen::RowVector3i cell = lattice.cells.row(e);
    const bool on_surface = (cell.array() == 0 || cell.array() == 3).any();
    if (cell[0] < 2) {
      CHECK(found.factors[e] == (on_surface || cell[0] == 1 ? Approx(0.2) : Approx(0.2).margin(1)));
    } else if (on_surface) {
      CHECK(found.factors[e] == 1);
      ++num_outside;
    }
  }
  CHECK(num_outside == 28);
  CHECK(found.num_outside == 28);
}

TEST_CASE("paint that cannot be meant is refused") {
  const TriangleMesh plain = make_box(Vector3d::Constant(0.8));
  TriangleMesh negative = painted_cube(grey_along_x), broken = negative;
  negative.colors(3, 1) = -0.5;
  broken.colors(5, 2) = std::numeric_limits<double>::infinity();
  const auto text_of = [&](const TriangleMesh& mesh) {
    const Failure refusal = failure_of([&] { factors_from_paint(mesh, plain, cube_lattice(), {}); });
    CHECK(refusal.code == 65);
    return refusal.message;
  };
  CHECK(contains(text_of(plain), "the mesh has no vertex colours"));
  CHECK(contains(text_of(negative), " vertex colours are negative or not finite, the first is that of vertex 3"));
  CHECK(contains(text_of(broken), "the first is that of vertex 5"));
  CHECK(contains(text_of(moved(painted_cube(grey_along_x), {3, 0, 0})), "touches no hex of the body"));
}
