// The smooth surface of coarse cages: exact where it must be, without creases, and near the trilinear one.
#include "embedding/smooth_surface.h"

#include <tbb/global_control.h>

#include <cmath>
#include <random>

#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;

namespace {

/// A cage of 6 x 2 x 2 cells, bent by a right angle along x.
struct Bent {
  Lattice lattice = make_box_lattice({6, 2, 2}, {0, -1, -1}, {1, 1, 1});
  Points nodes = lattice.rest_positions;
  Bent() {
    const double radius = 6 / (std::acos(-1.0) / 2);
    for (auto node : nodes.rowwise()) {
      const double angle = node[0] / radius, r = radius - node[1];
      node = Eigen::RowVector3d(r * std::sin(angle), radius - r * std::cos(angle), node[2]);
    }
  }
};

Points trilinear(const VectorXi& hex, const Points& local, const Lattice& lattice, const Points& nodes) {
  EmbeddedPoints points;
  points.hex = hex;
  points.weights.resize(hex.size(), 8);
  for (Eigen::Index p = 0; p < hex.size(); ++p)
    for (int n = 0; n < 8; ++n) {
      const auto of = [&](int axis, int bit) { return bit ? local(p, axis) : 1 - local(p, axis); };
      points.weights(p, n) = of(0, n >> 2) * of(1, n >> 1 & 1) * of(2, n & 1);
    }
  return deform_points(points, lattice.hexes, nodes);
}

/// Largest angle [degrees] between the normals of a material plane y = const on both sides of the faces between cells
/// along x. positions(hex, local) of 1 x 3 each.
template <class Positions>
double largest_jump(const Lattice& lattice, const Positions& positions) {
  const auto at = [&](int hex, const Vector3d& s) {
    VectorXi one(1);
    one[0] = hex;
    Points local(1, 3);
    local.row(0) = s.transpose();
    return Vector3d(positions(one, local).row(0).transpose());
  };
  constexpr double h = 1e-5;
  double largest = 0;
  for (int a = 0; a < int(lattice.num_hexes()); ++a)
    for (int b = 0; b < int(lattice.num_hexes()); ++b) {
      if (lattice.cells.row(b) != lattice.cells.row(a) + Eigen::RowVector3i(1, 0, 0)) continue;
      for (const double y : {0.1, 0.5, 1.0})
        for (const double z : {0.0, 0.35, 0.8}) {
          const auto normal = [&](int hex, double x, double inwards) {
            const Vector3d here = at(hex, {x, y, z});
            const Vector3d along = inwards * (at(hex, {x + inwards * h, y, z}) - here),
                           across = at(hex, {x, y, z + h}) - here;
            return Vector3d(along.cross(across).normalized());
          };
          const double cosine = normal(a, 1, -1).dot(normal(b, 0, 1));
          largest = std::max(largest, std::acos(std::min(cosine, 1.0)) * 180 / std::acos(-1.0));
        }
    }
  return largest;
}

}  // namespace

TEST_CASE("a linear motion of the cage moves the smooth surface linearly, also at the cage's ragged border") {
  const TriangleMesh mesh = blob(3);
  const Lattice lattice = voxelize(mesh, {.size = 60});
  const Embedding embedding = embed(mesh, lattice);
  Matrix3d A;
  A << 1.3, 0.2, -0.1, 0.4, 0.8, 0.3, -0.2, 0.1, 1.1;
  const Eigen::RowVector3d b(3, -2, 7);
  TriangleMesh out;
  deform_smoothly(embedding, lattice, (lattice.rest_positions * A.transpose()).rowwise() + b, out);
  const Points expected = (mesh.positions * A.transpose()).rowwise() + b;
  CHECK((out.positions - expected).cwiseAbs().maxCoeff() < 1e-12 * expected.cwiseAbs().maxCoeff());
}

TEST_CASE("the smooth surface passes through the nodes, whatever they do") {
  const Lattice lattice = make_box_lattice({3, 2, 2}, {0, 0, 0}, {1, 1, 1});
  std::mt19937 random(5);
  Points nodes = lattice.rest_positions;
  for (double& x : nodes.reshaped()) x += 0.3 * double(random()) / double(std::mt19937::max());
  for (int e = 0; e < int(lattice.num_hexes()); ++e)
    for (int n = 0; n < 8; ++n) {
      VectorXi hex(1);
      hex[0] = e;
      Points local(1, 3);
      local << (n >> 2), (n >> 1 & 1), (n & 1);
      CHECK((smooth_positions(hex, local, lattice, nodes).row(0) - nodes.row(lattice.hexes(e, n))).norm() < 1e-14);
    }
}

TEST_CASE(
    "where cells of a bent cage meet, normals jump by 15 degrees of the trilinear surface and by none of the smooth") {
  const Bent bent;
  const double before = largest_jump(bent.lattice, [&](const VectorXi& hex, const Points& local) {
    return trilinear(hex, local, bent.lattice, bent.nodes);
  });
  const double after = largest_jump(bent.lattice, [&](const VectorXi& hex, const Points& local) {
    return smooth_positions(hex, local, bent.lattice, bent.nodes);
  });
  CHECK(before == Approx(15).margin(0.1));
  CHECK(after < 0.01);
}

TEST_CASE("the smooth surface of a bent bar is nearer to the arc that it was bent to") {
  const Bent bent;
  const double radius = 6 / (std::acos(-1.0) / 2);
  const auto error = [&](bool is_smooth) {
    double largest = 0;
    for (int e = 0; e < int(bent.lattice.num_hexes()); ++e) {
      if (bent.lattice.cells(e, 1) != 1 || bent.lattice.cells(e, 0) < 1 || bent.lattice.cells(e, 0) > 4) continue;
      VectorXi hex(1);
      hex[0] = e;
      Points local(1, 3);
      local << 0.5, 1, 0.5;  // on the side y = 1, of the arc of radius - 1
      const Points place = is_smooth ? smooth_positions(hex, local, bent.lattice, bent.nodes)
                                     : trilinear(hex, local, bent.lattice, bent.nodes);
      const double r = std::hypot(place(0, 0), radius - place(0, 1));
      largest = std::max(largest, std::abs(r - (radius - 1)));
    }
    return largest;
  };
  CHECK(error(false) > 0.02);
  CHECK(error(true) < 0.1 * error(false));
}

TEST_CASE("parts of a cage that share no node do not touch each other's smooth surface") {
  Cells cells(2, 3);
  cells << 0, 0, 0, 2, 0, 0;
  const Lattice lattice = make_lattice(cells, {0, 0, 0}, {1, 1, 1});
  Points nodes = lattice.rest_positions, moved = nodes;
  for (auto node : moved.rowwise())
    if (node[0] > 1.5) node += Eigen::RowVector3d(5, 3, -2);
  VectorXi hex(1);
  hex[0] = 0;
  Points local(1, 3);
  local << 0.9, 0.2, 0.7;
  CHECK(smooth_positions(hex, local, lattice, nodes) == smooth_positions(hex, local, lattice, moved));
}

TEST_CASE("the smooth surface has the same bits for one thread and two") {
  const TriangleMesh mesh = make_sphere(1, 5);
  const Lattice lattice = voxelize(mesh, {.size = 60});
  const Embedding embedding = embed(mesh, lattice);
  std::mt19937 random(2);
  Points nodes = lattice.rest_positions;
  for (double& x : nodes.reshaped()) x += 0.1 * double(random()) / double(std::mt19937::max());
  TriangleMesh one, two;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    deform_smoothly(embedding, lattice, nodes, one);
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
  deform_smoothly(embedding, lattice, nodes, two);
  CHECK(one.positions == two.positions);
  CHECK(one.normals == two.normals);
}
