#include "tools/reproduce/limb_height.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/error.h"
#include "core/element/rotation.h"
#include "embedding/figure/figure.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tools/system/exit_code.h"

using namespace umax;

namespace {

/// Two legs of 1 m, at x = 0 .. 0.2 and x = 0.8 .. 1, under a hip of 1 m.
Points two_legs() {
  std::vector<Vector3d> points;
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 20; ++j)
      if (j > 10 || i <= 2 || i >= 8) points.push_back({0.1 * i, 0.1 * j, 0.3});
  return test::as_points(points);
}

const LimbBox left_leg{{-0.01, -0.01, 0}, {0.21, 0.51, 1}};

}  // namespace

TEST_CASE("a limb is what lies in its box, with its own height and length") {
  const Points rest = two_legs();
  const Limb leg = select_limb(rest, left_leg);
  CHECK(leg.vertices.size() == 3 * 11);
  CHECK(leg.top.size() == 3 * 2);
  CHECK(leg.bottom.size() == 3 * 2);
  CHECK(leg.rest_height == Approx(1).epsilon(1e-12));
  CHECK(leg.rest_length == Approx(0.9).epsilon(1e-12));
  for (const int vertex : leg.vertices) CHECK(rest(vertex, 0) < 0.3);
}

TEST_CASE("a limb that is crushed loses height and length, one that is turned loses height only") {
  const Points rest = two_legs();
  const Limb leg = select_limb(rest, left_leg);
  const Points crushed = rest * Vector3d(1, 0.3, 1).asDiagonal();
  CHECK(limb_height(leg, crushed) == Approx(0.3).epsilon(1e-12));
  CHECK(limb_length(leg, crushed) == Approx(0.27).epsilon(1e-12));
  const Points turned = rest * rotation_from_degrees({0, 0, 90}).transpose();
  CHECK(limb_height(leg, turned) == Approx(0.2).epsilon(1e-12));
  CHECK(limb_length(leg, turned) == Approx(0.9).epsilon(1e-12));

  // the other leg does not matter
  Points other = rest;
  for (Eigen::Index i = 0; i < other.rows(); ++i)
    if (other(i, 0) > 0.5) other(i, 1) *= 0.1;
  CHECK(limb_height(leg, other) == leg.rest_height);
}

TEST_CASE("the figure's right leg is on its right, reaches from the sole to above the knee and is in one piece") {
  const TriangleMesh figure = make_figure({.cell_size = 20e-3});
  const Limb leg = select_limb(figure.positions, figure_right_leg);
  CHECK(leg.rest_height == Approx(0.24 * 2).margin(0.02));
  CHECK(leg.rest_length == Approx(0.85 * 0.24 * 2).epsilon(0.15));
  std::vector<int> piece(figure.num_vertices(), -1);  // a smaller vertex of the same piece, or the vertex itself
  for (const int vertex : leg.vertices) {
    CHECK(figure.positions(vertex, 0) < -0.09);
    piece[vertex] = vertex;
  }
  const auto root = [&](int vertex) {
    while (piece[vertex] != vertex) vertex = piece[vertex];
    return vertex;
  };
  for (Eigen::Index t = 0; t < figure.num_triangles(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = figure.triangles(t, k), b = figure.triangles(t, (k + 1) % 3);
      if (piece[a] < 0 || piece[b] < 0) continue;
      const int low = std::min(root(a), root(b)), high = std::max(root(a), root(b));
      piece[high] = low;
    }
  for (const int vertex : leg.vertices) CHECK(root(vertex) == leg.vertices.front());
}

TEST_CASE("a box without vertices is refused") {
  const auto code = [](const Points& rest, const LimbBox& box) {
    return error_code_of([&] { select_limb(rest, box); });
  };
  CHECK(code(two_legs(), {{0.3, 0, 0}, {0.7, 0.2, 1}}) == exit_code_of(Fault::bad_data));
  CHECK(code(Points(0, 3), left_leg) == exit_code_of(Fault::bad_data));
}
