// Irregular hexes as a cage: which hex holds a point, and how much of it a surface fills.
#include "embedding/cage/hex_cage.h"

#include <tbb/global_control.h>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/element/hexahedron.h"
#include "embedding/cage/hex_search.h"
#include "embedding/embedding.h"
#include "embedding/surface/hex_faces.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"
#include "tests/support/distorted.h"

using namespace umax;
using namespace umax::testing;

namespace {

// a distorted box, turned and moved far from the axes
Lattice crooked_lattice(double share = 0.3, const Vector3d& centre = {7, -3, 11}) {
  Lattice lattice = test::distorted_lattice(make_box_lattice({5, 4, 6}, {-1.25, -1, -1.5}, {0.5, 0.5, 0.5}), share);
  const Matrix3d turn = test::Random(9).rotation();
  lattice.rest_positions = (lattice.rest_positions * turn.transpose()).rowwise() + centre.transpose();
  return lattice;
}

Vector3d point_in(const Lattice& lattice, Eigen::Index hex, const Vector3d& local) {
  return rest_nodes(lattice, hex).transpose() * shape_functions(2 * local - Vector3d::Ones());
}

}  // namespace

TEST_CASE("a point in an irregular hex is found there, with its coordinates") {
  const double share = GENERATE(0.0, 0.2, 0.35);
  const Lattice lattice = crooked_lattice(share);
  const HexSearch search(lattice);
  test::Random random(2);
  double worst = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto hex = Eigen::Index(random.uniform(0, double(lattice.num_hexes())));
    const Vector3d local = 0.5 * (random.vector(0.999) + Vector3d::Ones());
    Vector3d found;
    REQUIRE(search.find(point_in(lattice, hex, local), found) == hex);
    worst = std::max(worst, (found - local).cwiseAbs().maxCoeff());
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("nodes and points on shared faces lie in the lowest of their hexes") {
  const Lattice lattice = crooked_lattice();
  const HexSearch search(lattice);
  std::vector<int> lowest(std::size_t(lattice.num_nodes()), -1);
  for (int e = int(lattice.num_hexes()) - 1; e >= 0; --e)
    for (const int node : lattice.hexes.row(e)) lowest[std::size_t(node)] = e;
  const EmbeddedPoints nodes = embed_points(lattice.rest_positions, lattice);
  for (Eigen::Index node = 0; node < lattice.num_nodes(); ++node) {
    CHECK(nodes.hex[node] == lowest[std::size_t(node)]);
    CHECK(nodes.weights.row(node).maxCoeff() == 1);  // its own node, exactly
  }
  for_each_face(hex_faces(lattice.hexes), [&](auto first, auto last) {
    Vector3d middle = Vector3d::Zero(), local;
    for (const int node : first->corners) middle += 0.25 * lattice.rest_positions.row(node).transpose();
    CHECK(search.find(middle, local) == first->hex);
    CHECK((last - first == 1 || first->hex < first[1].hex));
  });
}

TEST_CASE("a surface in irregular hexes has weights that sum to one, and follows linear motions") {
  const Lattice lattice = crooked_lattice();
  const TriangleMesh mesh = moved(make_sphere(0.9, 4), {7, -3, 11});
  const Embedding embedding = embed(mesh, lattice);
  const EmbeddedPoints points = points_of(embedding);
  CHECK((points.weights.rowwise().sum().array() - 1).abs().maxCoeff() < 1e-14);
  CHECK(points.weights.minCoeff() > -1e-8);
  CHECK((deform_points(points, lattice.hexes, lattice.rest_positions) - mesh.positions).cwiseAbs().maxCoeff() < 1e-12);
  Matrix3d A;
  A << 1.3, 0.2, -0.1, 0.4, 0.8, 0.3, -0.2, 0.1, 1.1;
  const Eigen::RowVector3d b(3, -2, 7);
  TriangleMesh out;
  deform(embedding, lattice.hexes, (lattice.rest_positions * A.transpose()).rowwise() + b, out);
  CHECK((out.positions - ((mesh.positions * A.transpose()).rowwise() + b)).cwiseAbs().maxCoeff() < 1e-11);
}

TEST_CASE("irregular hexes that happen to be a grid hold points as the grid does") {
  const Lattice grid = make_box_lattice({6, 5, 4}, {-1.5, -1.2, -1.1}, {0.5, 0.48, 0.55});
  const Lattice irregular = make_irregular_lattice(grid.rest_positions, grid.hexes);
  const TriangleMesh mesh = make_sphere(1, 4);
  const EmbeddedPoints a = embed_points(mesh.positions, grid), b = embed_points(mesh.positions, irregular);
  CHECK(a.hex == b.hex);
  CHECK((a.weights - b.weights).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("embedding in irregular hexes has the same bits for any number of threads") {
  const Lattice lattice = crooked_lattice();
  const TriangleMesh mesh = moved(make_sphere(0.9, 4), {7, -3, 11});
  const EmbeddedPoints a = embed_points(mesh.positions, lattice);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const EmbeddedPoints b = embed_points(mesh.positions, lattice);
  CHECK(a.hex == b.hex);
  CHECK(a.weights == b.weights);
}

TEST_CASE("a vertex outside irregular hexes is named, with its distance") {
  const Lattice lattice =
      test::distorted_lattice(make_box_lattice({3, 3, 3}, {0, 0, 0}, {1, 1, 1}), 0.2);  // its outline is the box
  TriangleMesh mesh = moved(make_sphere(0.5, 2), {1.5, 1.5, 1.5});
  embed(mesh, lattice);
  mesh.positions.row(7) << 1.2, 3.25, 1.7;
  mesh.positions.row(9) << 1.2, 1.5, -4;
  try {
    embed(mesh, lattice);
    FAIL("was accepted");
  } catch (const Error& error) {
    const std::string text = error.what();
    CAPTURE(text);
    CHECK(error.fault() == Fault::bad_data);
    CHECK(text.find(
              "vertex 7: lies outside the cage, got (1.2, 3.25, 1.7), 0.25 m from its nearest face (and 1 more)") == 0);
  }
  Points corner(1, 3);
  corner << -3, -4, 0;
  try {
    embed_points(corner, lattice, "probe");
    FAIL("was accepted");
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find("5 m from its nearest face;") != std::string::npos);
  }
}

TEST_CASE("the share of each irregular hex inside a surface adds up to its volume") {
  const Lattice lattice = crooked_lattice(0.25);
  const TriangleMesh mesh = moved(make_sphere(0.9, 5), {7, -3, 11});
  CageReport report;
  const Lattice cage = make_hex_cage(mesh, lattice.rest_positions, lattice.hexes, {}, &report);
  CHECK(hex_volumes(cage).sum() == Approx(2.5 * 2 * 3).epsilon(1e-12));
  CHECK(report.filled_volume == Approx(unit_sphere_volume * 0.9 * 0.9 * 0.9).epsilon(0.01));
  CHECK(report.mesh_volume == Approx(unit_sphere_volume * 0.9 * 0.9 * 0.9).epsilon(0.01));
  CHECK(report.num_islands == 1);
  CHECK(report.num_loose_parts == 1);
  CHECK(cage.filled_fraction.minCoeff() == 0);
  CHECK(cage.filled_fraction.maxCoeff() <= 1);

  const HexSurface own = surface_of(lattice.rest_positions, lattice.hexes);
  const Lattice body = make_hex_cage(own.mesh, lattice.rest_positions, lattice.hexes, {.is_the_body = true}, &report);
  CHECK(body.filled_fraction == VectorXd::Ones(120));
  CHECK(report.mesh_volume == Approx(15).epsilon(1e-12));
}

TEST_CASE("islands and hinges of irregular cages are counted") {
  // two boxes that share an edge, and one apart
  Cells cells(3, 3);
  cells << 0, 0, 0, 1, 1, 0, 5, 0, 0;
  const Lattice grid = make_lattice(cells, Vector3d::Zero(), Vector3d::Ones());
  CageReport regular, irregular;
  report_connections(grid, regular);
  report_connections(make_irregular_lattice(grid.rest_positions, grid.hexes), irregular);
  CHECK(irregular.num_islands == 2);
  CHECK(irregular.num_loose_parts == 3);
  CHECK(regular.num_islands == 2);
  CHECK(regular.num_loose_parts == 3);
  CHECK(irregular.notes == regular.notes);
}
