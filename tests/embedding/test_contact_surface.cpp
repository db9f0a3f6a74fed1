// The border between a mesh's inside and the outside.
#include "embedding/surface/contact_surface.h"

#include <ctime>
#include <numbers>

#include "embedding/surface/mesh_report.h"
#include "embedding/surface/topology.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;

namespace {

Vector3d centre_of(const TriangleMesh& mesh, Eigen::Index t) {
  return (mesh.positions.row(mesh.triangles(t, 0)) + mesh.positions.row(mesh.triangles(t, 1)) +
          mesh.positions.row(mesh.triangles(t, 2)))
             .transpose() /
         3;
}

Vector3d normal_of(const TriangleMesh& mesh, Eigen::Index t) {
  const Vector3d a = mesh.positions.row(mesh.triangles(t, 0)), b = mesh.positions.row(mesh.triangles(t, 1)),
                 c = mesh.positions.row(mesh.triangles(t, 2));
  return (b - a).cross(c - a).normalized();
}

/// A box of twelve triangles.
TriangleMesh coarse_box(const Vector3d& size) {
  TriangleMesh box;
  box.positions.resize(8, 3);
  for (int n = 0; n < 8; ++n)
    box.positions.row(n) << (n & 4 ? 0.5 : -0.5) * size[0], (n & 2 ? 0.5 : -0.5) * size[1],
        (n & 1 ? 0.5 : -0.5) * size[2];
  box.triangles.resize(12, 3);
  box.triangles << 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1,
      7, 3;
  return box;
}

/// The same triangles in the same order, directed alike.
void check_same_triangles(const TriangleMesh& a, const TriangleMesh& b) {
  REQUIRE(a.num_triangles() == b.num_triangles());
  double largest = 0;
  for (Eigen::Index t = 0; t < a.num_triangles(); ++t) {
    largest = std::max(largest, (centre_of(a, t) - centre_of(b, t)).norm());
    largest = std::max(largest, (normal_of(a, t) - normal_of(b, t)).norm());
  }
  CHECK(largest < 1e-12);
}

}  // namespace

TEST_CASE("a sound closed mesh is its own contact surface, and one that is inside out is turned") {
  const TriangleMesh mesh = GENERATE(make_sphere(1), make_box({1, 2, 3}), coarse_box({1, 2, 3}), blob(3));
  check_same_triangles(contact_surface(mesh), mesh);
  check_same_triangles(contact_surface(turned_inside_out(mesh)), mesh);
}

TEST_CASE("some triangles that face inwards are turned") {
  TriangleMesh mesh = make_sphere(1, 3);
  const TriangleMesh sound = mesh;
  for (int t = 0; t < 200; t += 7) std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
  check_same_triangles(contact_surface(mesh), sound);
}

TEST_CASE("a part inside another is left out, and a cavity stays") {
  const TriangleMesh outer = make_sphere(1, 4), inner = make_sphere(0.5, 3);
  check_same_triangles(contact_surface(joined(outer, inner)), outer);
  const TriangleMesh hollow = joined(outer, turned_inside_out(inner));
  check_same_triangles(contact_surface(hollow), hollow);
  const TriangleMesh apart = joined(outer, moved(inner, {1.6, 0, 0}));
  check_same_triangles(contact_surface(apart), apart);
}

TEST_CASE("of two balls that overlap, what lies in the other is left out, but for the triangles that are cut") {
  const Vector3d other_centre(1.2, 0.1, 0);
  const TriangleMesh border = contact_surface(joined(make_sphere(1), moved(make_sphere(1), other_centre)));
  double deepest = 0, outwards = 1;
  for (Eigen::Index t = 0; t < border.num_triangles(); ++t) {
    const Vector3d centre = centre_of(border, t);
    const double radius = centre.norm(), other_radius = (centre - other_centre).norm();
    const Vector3d normal = normal_of(border, t);
    outwards = std::min(outwards, std::max(normal.dot(centre), normal.dot(centre - other_centre)));
    deepest = std::max(deepest, 1 - std::max(radius, other_radius));
  }
  CHECK(outwards > 0.9);
  CHECK(deepest < 2.2 / 256);
  // two spherical zones: 2 pi r h, h = r + half the distance
  const double distance = other_centre.norm();
  CHECK(surface_area(border) == Approx(2 * 2 * std::numbers::pi * (1 + distance / 2)).epsilon(0.01));
  CHECK(signed_volume(border.positions, border.triangles) > 0);
}

TEST_CASE("large triangles that are buried in part are cut") {
  // a bar through a box: 4 faces of which a third is inside, and two faces of the box that the bar comes through
  const TriangleMesh box = coarse_box({1, 1, 1}), bar = coarse_box({3, 0.3, 0.3});
  const TriangleMesh border = contact_surface(joined(box, bar));
  CHECK(surface_area(border) == Approx(6 - 2 * 0.09 + 2 * 4 * 0.3 + 2 * 0.09).epsilon(0.02));
  double deepest = 0;
  for (Eigen::Index t = 0; t < border.num_triangles(); ++t) {
    const Vector3d from_box = centre_of(border, t).cwiseAbs() - Vector3d(0.5, 0.5, 0.5);
    deepest = std::max(deepest, -from_box.maxCoeff());
  }
  CHECK(deepest < 3.0 / 64);
}

TEST_CASE("walls between parts that touch face to face are left out") {
  const TriangleMesh border = contact_surface(joined(coarse_box({1, 1, 1}), moved(coarse_box({1, 1, 1}), {1, 0, 0})));
  CHECK(border.num_triangles() == 20);
  CHECK(surface_area(border) == Approx(10));
}

TEST_CASE("a mesh without an inside has no contact surface, and small holes are capped") {
  const TriangleMesh ball = make_sphere(1);
  CHECK(contact_surface(make_plane(1)).num_triangles() == 0);
  CHECK(contact_surface(part_of(ball, [](const Vector3d& p) { return p[1] < 0.5; })).num_triangles() == 0);
  CHECK(contact_surface({}).num_triangles() == 0);
  TriangleMesh both_sides = make_plane(1);
  CHECK(contact_surface(joined(both_sides, turned_inside_out(both_sides))).num_triangles() == 0);

  // a hole of 0.2 % of the area
  const TriangleMesh pierced = part_of(ball, [](const Vector3d& p) { return p[1] < 0.996; });
  REQUIRE(pierced.num_triangles() < ball.num_triangles());
  const TriangleMesh border = contact_surface(pierced);
  CHECK(report_mesh(border).watertight);
  CHECK(signed_volume(border.positions, border.triangles) == Approx(unit_sphere_volume).epsilon(2e-3));

  // an open sheet beside it does not count, wherever it is
  const TriangleMesh cape = moved(make_plane(3), {0, 0.2, 0});
  check_same_triangles(contact_surface(joined(ball, cape)), ball);
}

TEST_CASE("a cone of 80,000 triangles at its tip takes about as long as another mesh of as many triangles") {
  const TriangleMesh mesh = cone(40000);
  const std::clock_t start = std::clock();
  const TriangleMesh border = contact_surface(mesh);
  const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;  // of all threads, others' do not count
  CHECK(seconds < 6);  // where columns of a share of all triangles took 35
  check_same_triangles(border, mesh);
}

TEST_CASE("of triangles that lie in one place, those that face alike count together and opposite ones cancel out") {
  const TriangleMesh mesh = coarse_box({1, 2, 3});
  TriangleMesh copied = mesh;
  constexpr int num_pairs = 20000;
  copied.triangles.conservativeResize(12 + 2 * num_pairs, 3);
  for (int k = 0; k < num_pairs; ++k) {
    copied.triangles.row(12 + 2 * k) << mesh.triangles(3, 1), mesh.triangles(3, 2), mesh.triangles(3, 0);
    copied.triangles.row(13 + 2 * k) << mesh.triangles(3, 0), mesh.triangles(3, 2), mesh.triangles(3, 1);
  }
  const TriangleMesh border = contact_surface(copied);
  CHECK(signed_volume(border.positions, border.triangles) != 0);
  // all copies of the face border the outside: they have the inside behind them
  REQUIRE(border.num_triangles() == copied.num_triangles());
  double outwards = 1;
  for (Eigen::Index t = 0; t < border.num_triangles(); ++t)
    outwards = std::min(outwards, normal_of(border, t).dot(centre_of(border, t)));
  CHECK(outwards > 0);
}
