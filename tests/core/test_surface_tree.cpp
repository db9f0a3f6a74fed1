// What penetration is measured with, against closed forms and plain searches: triangles, surface trees, hulls of hexes.
#include "tests/support/surface_tree.h"

#include <limits>
#include <numbers>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/closed_meshes.h"
#include "tests/support/hex_hulls.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double pi = std::numbers::pi;

Triangle random_triangle(Random& random) {
  return {random.vector(1), random.vector(1), random.vector(1)};
}

double exact_winding(const SurfaceView& surface, const Vector3d& x) {
  double sum = 0;
  for (int t = 0; t < int(surface.tree.triangles.rows()); ++t)
    if (!surface.left_out || !surface.left_out->triangles[t]) sum += solid_angle(triangle_at(surface, t), x);
  return sum / (4 * pi);
}

double exact_distance(const SurfaceView& surface, const Vector3d& x) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < int(surface.tree.triangles.rows()); ++t)
    if (!surface.left_out || !surface.left_out->triangles[t])
      nearest = std::min(nearest, squared_distance(triangle_at(surface, t), x));
  return std::sqrt(nearest);
}

}  // namespace

TEST_CASE("an octant's triangle fills an eighth of the sky, less by sign from its front, and its corners see none") {
  const Triangle triangle{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  CHECK(solid_angle(triangle, {0, 0, 0}) == Approx(pi / 2));
  CHECK(solid_angle(triangle, Vector3d::Constant(2.0 / 3)) == Approx(-pi / 2));
  CHECK(solid_angle(triangle, triangle.b) == 0);
}

TEST_CASE("the distance to a triangle is that to its nearest point") {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Triangle triangle = random_triangle(random);
    const Vector3d x = random.vector(2);
    double nearest = 1e9;
    for (int u = 0; u <= 200; ++u)
      for (int v = 0; u + v <= 200; ++v)
        nearest = std::min(
            nearest,
            (triangle.a + u / 200.0 * (triangle.b - triangle.a) + v / 200.0 * (triangle.c - triangle.a) - x).norm());
    const double distance = std::sqrt(squared_distance(triangle, x));
    CHECK(distance <= nearest + 1e-12);
    CHECK(distance > nearest - 0.02);
  }
  CHECK(squared_distance({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}, {2, 2, 0}) == Approx(4));  // without area
  CHECK(squared_distance({{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}, {1, 2, 0}) == Approx(4));
}

TEST_CASE("a segment crosses a triangle that it passes through, and one of two at their edge") {
  const Triangle left{{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, right{{0, 1, 0}, {0, 0, 0}, {1, 0, 0}};
  const auto cut = crossing({0.25, 0.25, -1}, {0.25, 0.25, 3}, right);
  REQUIRE(cut);
  CHECK(*cut == Approx(0.25));
  CHECK(!crossing({0.25, 0.25, -1}, {0.25, 0.25, 3}, left));
  CHECK(!crossing({0.25, 0.25, 0}, {0.25, 0.25, 3}, right));  // touches
  CHECK(!crossing({0.25, 0.25, 1}, {0.25, 0.25, 3}, right));
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d at(0, random.uniform(0.1, 0.9), 0), along = random.vector(1);
    CHECK((crossing(at - along, at + along, left) || crossing(at - along, at + along, right)));
  }
}

TEST_CASE("searches of a surface's tree find what plain ones find, with triangles left out too") {
  const TriangleMesh mesh = ball_mesh({0, 0, 0}, 1, 20);
  const SurfaceTree tree = build_tree(mesh.triangles, mesh.positions);
  const TreeShape shape = shape_tree(tree, mesh.positions * Vector3d(1, 0.6, 1.4).asDiagonal());
  std::vector<int> some;
  for (int t = 0; t < int(tree.triangles.rows()); ++t)
    if (tree.triangles(t, 0) % 7 == 0 || (t > 1000 && t < 1300)) some.push_back(t);
  const LeftOut left_out = leave_out(tree, some);
  Random random(2);
  for (const LeftOut* out : {static_cast<const LeftOut*>(nullptr), &left_out}) {
    const SurfaceView surface{tree, shape, out};
    for (int i = 0; i < 200; ++i) {
      const Vector3d x = random.vector(1.6);
      CHECK(std::abs(winding_number(surface, x) - exact_winding(surface, x)) < 0.03);
      CHECK(distance(surface, x) == exact_distance(surface, x));
      const Box box(x, x + Vector3d(0.1, 0.2, 0.3));
      std::vector<int> found;
      for (int t = 0; t < int(tree.triangles.rows()); ++t) {
        const auto [a, b, c] = triangle_at(surface, t);
        const Box around(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c));
        if (around.intersects(box) && !(out && out->triangles[t])) found.push_back(t);
      }
      std::vector<int> by_tree = triangles_in(surface, box);
      std::sort(by_tree.begin(), by_tree.end());
      CHECK(by_tree == found);
      CHECK(has_triangles_in(surface, box) == !found.empty());
    }
  }
}

TEST_CASE("a hull holds a turned hex's inside and what is near it, not what is behind a face") {
  const Matrix3d rotation = Random(6).rotation();
  const Model model = make_model({turned(make_block({1, 1, 1}, {0, 0, 0}, 1), rotation)}, {});
  const HexHull hull = hex_hulls(model, 0, model.rest_positions).front();
  CHECK(may_hold(hull, rotation * Vector3d(0.1, 0.9, 0.5), 0));
  CHECK(may_hold(hull, rotation * Vector3d(0.1, 1.1, 0.5), 0.11));
  CHECK(!may_hold(hull, rotation * Vector3d(0.1, 1.1, 0.5), 0.09));
  CHECK(!may_hold(hull, rotation * Vector3d(-0.1, 0.5, 0.5), 0.09));
}
