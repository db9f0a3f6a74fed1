#include <tbb/global_control.h>

#include <random>

#include "core/base/error.h"
#include "core/element/rotation.h"
#include "embedding/embedding.h"
#include "embedding/loose_vertices.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;

TEST_CASE("embedding weights sum to one and reproduce the vertices") {
  const TriangleMesh mesh = blob(GENERATE(1u, 2u));
  const Lattice lattice = voxelize(mesh, {.size = 200});
  const Embedding embedding = embed(mesh, lattice);
  const EmbeddedPoints points = points_of(embedding);
  CHECK((points.weights.rowwise().sum().array() - 1).abs().maxCoeff() < 1e-14);
  CHECK(points.weights.minCoeff() > -1e-8);
  CHECK((deform_points(points, lattice.hexes, lattice.rest_positions) - mesh.positions).cwiseAbs().maxCoeff() <
        1e-12 * 10);
}

TEST_CASE("a linear motion of the cage moves the surface linearly") {
  const TriangleMesh mesh = blob(3);
  const Lattice lattice = voxelize(mesh, {.size = 300});
  const Embedding embedding = embed(mesh, lattice);
  Matrix3d A;
  A << 1.3, 0.2, -0.1, 0.4, 0.8, 0.3, -0.2, 0.1, 1.1;
  const Eigen::RowVector3d b(3, -2, 7);
  const Points nodes = (lattice.rest_positions * A.transpose()).rowwise() + b;
  TriangleMesh out;
  deform(embedding, lattice.hexes, nodes, out);
  const Points expected = (mesh.positions * A.transpose()).rowwise() + b;
  CHECK((out.positions - expected).cwiseAbs().maxCoeff() < 1e-12 * expected.cwiseAbs().maxCoeff());
}

TEST_CASE("deform agrees with the trilinear weights for any nodes") {
  const TriangleMesh mesh = blob(4);
  const Lattice lattice = voxelize(mesh, {.size = 150});
  const Embedding embedding = embed(mesh, lattice);
  std::mt19937 random(5);
  Points nodes = lattice.rest_positions;
  for (double& x : nodes.reshaped()) x += 0.1 * double(random()) / double(random.max());
  TriangleMesh out;
  deform(embedding, lattice.hexes, nodes, out);
  CHECK((out.positions - deform_points(points_of(embedding), lattice.hexes, nodes)).cwiseAbs().maxCoeff() < 1e-13);
}

TEST_CASE("forces on a surface do the same work on its cage's nodes, with the same sum and torque") {
  const TriangleMesh mesh = blob(4);
  const Lattice lattice = voxelize(mesh, {.size = 150});
  const EmbeddedPoints points = points_of(embed(mesh, lattice));
  auto random_like = [random = std::mt19937(6)](Eigen::Index rows) mutable {
    Points all(rows, 3);
    for (double& x : all.reshaped()) x = double(random()) / double(random.max()) - 0.5;
    return all;
  };
  const Points forces = random_like(mesh.num_vertices()), motion = random_like(lattice.num_nodes());
  const Points nodal = nodal_forces(points, lattice.hexes, lattice.num_nodes(), forces);
  const double work = forces.cwiseProduct(deform_points(points, lattice.hexes, motion)).sum();
  CHECK(nodal.cwiseProduct(motion).sum() == Approx(work).epsilon(1e-12));
  CHECK((nodal.colwise().sum() - forces.colwise().sum()).norm() < 1e-11);
  Eigen::RowVector3d torque = Eigen::RowVector3d::Zero(), of_nodes = torque;
  for (Eigen::Index p = 0; p < forces.rows(); ++p) torque += mesh.positions.row(p).cross(forces.row(p));
  for (Eigen::Index n = 0; n < nodal.rows(); ++n) of_nodes += lattice.rest_positions.row(n).cross(nodal.row(n));
  CHECK((torque - of_nodes).norm() < 1e-10);
}

TEST_CASE("normals of a sphere stretched to an ellipsoid are the ellipsoid's, of second order in the edge") {
  double errors[2] = {0, 0};
  for (int level : {0, 1}) {
    const TriangleMesh mesh = make_sphere(1, 4 + level);
    const Lattice lattice = voxelize(mesh, {.size = 0.5});
    const Embedding embedding = embed(mesh, lattice);
    const Vector3d stretch(1.5, 0.7, 1.1);
    const Points nodes = lattice.rest_positions * stretch.asDiagonal();
    TriangleMesh out;
    deform(embedding, lattice.hexes, nodes, out);
    for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v) {
      const Vector3d exact = mesh.positions.row(v).transpose().cwiseQuotient(stretch).normalized();
      errors[level] = std::max(errors[level], (out.normals.row(v).transpose() - exact).norm());
    }
  }
  CHECK(errors[0] < 0.02);
  CHECK(errors[1] < 0.6 * errors[0]);
}

TEST_CASE("normals are smooth across split vertices and hard across creases") {
  // the facets of a sphere with three vertices of their own each, as STL has them
  const TriangleMesh sphere = make_sphere(1, 3);
  TriangleMesh facets;
  facets.positions.resize(3 * sphere.num_triangles(), 3);
  facets.triangles.resize(sphere.num_triangles(), 3);
  for (int t = 0; t < int(sphere.num_triangles()); ++t)
    for (int k = 0; k < 3; ++k) {
      facets.positions.row(3 * t + k) = sphere.positions.row(sphere.triangles(t, k));
      facets.triangles(t, k) = 3 * t + k;
    }
  compute_normals(facets);
  CHECK((facets.normals - facets.positions).rowwise().norm().maxCoeff() < 0.06);

  TriangleMesh box = make_box({1, 2, 3});
  const Points exact = box.normals;
  compute_normals(box);
  CHECK((box.normals - exact).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("where thousands of triangles with vertices of their own meet, normals take as much as the triangles do") {
  const TriangleMesh joined_cone = cone(20000);
  TriangleMesh soup;
  soup.positions = joined_cone.positions(joined_cone.triangles.reshaped<Eigen::RowMajor>(), Eigen::all);
  soup.triangles.resize(joined_cone.num_triangles(), 3);
  for (int corner = 0; corner < int(soup.triangles.size()); ++corner) soup.triangles(corner / 3, corner % 3) = corner;
  const VertexFans fans = make_vertex_fans(soup);
  CHECK(fans.entries.size() < 10 * std::size_t(soup.triangles.size()));
  compute_normals(soup);
  CHECK((soup.normals.row(0) - soup.normals.row(6)).norm() < 1e-2);  // at the tip, of neighbours
}

TEST_CASE("deformed surfaces have the same bits for any number of threads") {
  const TriangleMesh mesh = make_sphere(1, 6);
  const Lattice lattice = voxelize(mesh, {.size = 100});
  const Points nodes = (1.1 * lattice.rest_positions.array() + 0.05 * lattice.rest_positions.array().sin()).matrix();
  TriangleMesh out[2];
  Lattice lattices[2];
  for (int i : {0, 1}) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, std::size_t(1 + 3 * i));
    lattices[i] = voxelize(mesh, {.size = 100});
    deform(embed(mesh, lattice), lattice.hexes, nodes, out[i]);
  }
  CHECK((out[0].positions.array() == out[1].positions.array()).all());
  CHECK((out[0].normals.array() == out[1].normals.array()).all());
  CHECK((lattices[0].filled_fraction.array() == lattices[1].filled_fraction.array()).all());
  CHECK(lattices[0].cell_size == lattices[1].cell_size);
}

TEST_CASE("a point on a shared face belongs to the hex with the lowest index") {
  const Lattice lattice = make_box_lattice({2, 2, 2}, {0, 0, 0}, {1, 1, 1});
  Points points(4, 3);
  points << 1, 1, 1, 1.5, 1, 0.5, 2, 2, 2, 0, 0, 0;
  const EmbeddedPoints embedded = embed_points(points, lattice);
  CHECK(embedded.hex[0] == 0);
  CHECK(embedded.hex[1] == 4);
  CHECK(embedded.hex[2] == 7);
  CHECK(embedded.hex[3] == 0);
}

TEST_CASE("a point outside the cage is named") {
  const Lattice lattice = make_box_lattice({2, 1, 1}, {0, 0, 0}, {1, 1, 1});
  Points points(2, 3);
  points << 0.5, 0.5, 0.5, 2.5, 0.5, 0.5;
  try {
    embed_points(points, lattice, "probe");
    FAIL("must throw");
  } catch (const Error& error) {
    CHECK(error.fault() == Fault::bad_data);
    CHECK(std::string(error.what()).find("probe 1") != std::string::npos);
    CHECK(std::string(error.what()).find("2.5") != std::string::npos);
  }
}

TEST_CASE("vertices of no triangle move as the cage does inside of it, and rigidly with the nearest hex outside") {
  const Lattice lattice = make_box_lattice({5, 3, 4}, {-1, 0, 2}, {0.3, 0.5, 0.4});
  std::srand(5);
  Points points = 2 * Points::Random(60, 3);
  points.rowwise() += Eigen::RowVector3d(0, 0.7, 2.5);
  const LooseVertices loose = tie_loose_vertices(points, lattice);
  CHECK(loose.inside.size() > 2);
  CHECK(loose.outside.size() > 30);
  CHECK((deform_loose_vertices(loose, lattice, lattice.rest_positions) - points).cwiseAbs().maxCoeff() < 1e-12);

  // the nearest hex, by trying all
  for (std::size_t i = 0; i < loose.outside.size(); ++i) {
    int nearest = 0;
    double least = 1e9;
    for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
      const double distance = (rest_nodes(lattice, e).colwise().mean() - points.row(loose.outside[i])).norm();
      if (distance < least - 1e-12) nearest = int(e), least = distance;
    }
    CHECK(loose.nearest_hex[i] == nearest);
  }

  // a stretch moves those inside by itself, those outside with their hex's centre alone; a turn turns all
  const Matrix3d turn = rotation_from_degrees({20, -70, 130});
  const Matrix3d stretch = Vector3d(1.3, 0.8, 1.1).asDiagonal();
  const Points now = deform_loose_vertices(loose, lattice, lattice.rest_positions * (turn * stretch).transpose());
  for (const Eigen::Index v : loose.inside)
    CHECK((now.row(v).transpose() - turn * stretch * points.row(v).transpose()).norm() < 1e-12);
  for (std::size_t i = 0; i < loose.outside.size(); ++i) {
    const Vector3d centre = rest_nodes(lattice, loose.nearest_hex[i]).colwise().mean();
    const Vector3d offset = points.row(loose.outside[i]).transpose() - centre;
    CHECK((now.row(loose.outside[i]).transpose() - turn * (stretch * centre + offset)).norm() < 1e-12);
  }
}
