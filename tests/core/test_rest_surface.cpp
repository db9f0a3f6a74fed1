// The exact rest surface: nearest points, signs, sides and bounds.
#include "core/model/rest_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "embedding/surface/shapes.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using test::Random;

namespace {

constexpr double anywhere = std::numeric_limits<double>::infinity();

Vector3d random_point(Random& random, double reach) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

double segment_distance(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const double share = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (a + share * (b - a) - p).norm();
}

// distance to a triangle: of its plane where the point is above it, else of its edges
double triangle_distance(const RestSurface& surface, int t, const Vector3d& p) {
  const Vector3d n = surface.triangle_normals.row(t).transpose();
  double least = anywhere;
  bool is_above = true;
  for (int k = 0; k < 3; ++k) {
    const Vector3d a = corner_of(surface, t, k), b = corner_of(surface, t, (k + 1) % 3);
    least = std::min(least, segment_distance(a, b, p));
    is_above = is_above && n.cross(b - a).dot(p - a) >= 0;
  }
  return is_above ? std::abs(n.dot(p - corner_of(surface, t, 0))) : least;
}

double largest_height(const RestSurface& surface, const Vector3d& p) {
  double height = -anywhere;
  for (int t = 0; t < int(surface.triangles.rows()); ++t)
    height = std::max(height, surface.triangle_normals.row(t).dot((p - corner_of(surface, t, 0)).transpose()));
  return height;
}

// a sphere with dents and bumps
RestSurface make_rough_sphere(Random& random) {
  TriangleMesh sphere = make_sphere(1, 2);
  for (Eigen::Index v = 0; v < sphere.positions.rows(); ++v) sphere.positions.row(v) *= random.uniform(0.9, 1.1);
  return make_rest_surface(sphere.positions, sphere.triangles);
}

// a roof along z, its ridge at the origin, with this angle between its two sides: convex and closed
RestSurface make_roof(double angle) {
  const double x = std::sin(angle / 2), y = -std::cos(angle / 2);
  Points positions(6, 3);
  positions << 0, 0, -1, 0, 0, 1, -x, y, -1, -x, y, 1, x, y, -1, x, y, 1;
  Triangles triangles(8, 3);
  triangles << 0, 2, 3, 0, 3, 1, 0, 1, 5, 0, 5, 4, 2, 4, 5, 2, 5, 3, 0, 4, 2, 1, 3, 5;
  return make_rest_surface(positions, triangles);
}

// The sphere with a vertex on an edge of each triangle, and a needle that fills the place between the edge's halves and
// the edge. The needles' own normals are rounding.
RestSurface make_sphere_with_needles() {
  const TriangleMesh sphere = make_sphere(1, 3);
  const Eigen::Index num_vertices = sphere.positions.rows(), count = sphere.triangles.rows();
  Points positions(num_vertices + count, 3);
  positions.topRows(num_vertices) = sphere.positions;
  Triangles triangles(3 * count, 3);
  for (Eigen::Index t = 0; t < count; ++t) {
    const int a = sphere.triangles(t, 0), b = sphere.triangles(t, 1), c = sphere.triangles(t, 2);
    const int middle = int(num_vertices + t);
    positions.row(middle) = positions.row(a) + (positions.row(b) - positions.row(a)) / 3;
    triangles.middleRows(3 * t, 3) << a, middle, c, middle, b, c, a, b, middle;
  }
  return make_rest_surface(positions, triangles);
}

// a square sheet of a given thickness about y = 0, with coarse sides
RestSurface make_sheet(double thickness) {
  const TriangleMesh box = make_box({1, thickness, 1});
  return make_rest_surface(box.positions, box.triangles);
}

}  // namespace

TEST_CASE("the distance from a box is its closed form, on faces, edges and corners, inside and outside") {
  const Vector3d half(0.5, 0.3, 0.2);
  const TriangleMesh box = make_box(2 * half);
  const RestSurface surface = make_rest_surface(box.positions, box.triangles);
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = random_point(random, 0.8);
    const SurfaceHit hit = nearest_point(surface, p, anywhere);
    CHECK(hit.distance == Approx(test::box_distance(p, -half, half)).margin(1e-12));
    CHECK((p - hit.distance * hit.normal - hit.point).norm() < 1e-9);
    const DistanceBounds bounds = distance_bounds(surface, p);
    CHECK(bounds.low <= hit.distance);
    CHECK(bounds.high >= hit.distance);
  }
}

TEST_CASE("the nearest point is that of a search through all triangles") {
  Random random(2);
  const RestSurface surface = make_rough_sphere(random);
  for (int i = 0; i < 500; ++i) {
    const Vector3d p = random_point(random, 1.5);
    double least = anywhere;
    for (int t = 0; t < int(surface.triangles.rows()); ++t) least = std::min(least, triangle_distance(surface, t, p));
    CHECK(std::abs(nearest_point(surface, p, anywhere).distance) == Approx(least).margin(1e-14));
    CHECK(nearest_point(surface, p, least * (1 + 1e-9)).triangle >= 0);
    CHECK(nearest_point(surface, p, least * (1 - 1e-9)).triangle == -1);
  }
}

TEST_CASE("of the triangles at a corner the lowest is the nearest") {
  Random random(4);
  const RestSurface surface = make_rough_sphere(random);
  for (int v = 0; v < int(surface.vertices.rows()); ++v) {
    int lowest = 0;
    while (!(surface.triangles.row(lowest).array() == v).any()) ++lowest;
    CHECK(nearest_point(surface, surface.vertices.row(v).transpose(), anywhere).triangle == lowest);
  }
}

TEST_CASE("sharp tetrahedra have an inside and an outside") {
  Random random(5);
  Triangles triangles(4, 3);
  triangles << 0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0;
  for (int i = 0; i < 100; ++i) {
    Points positions(4, 3);
    for (int v = 0; v < 4; ++v) positions.row(v) = random_point(random, 1).transpose();
    const Eigen::RowVector3d a = positions.row(0), b = positions.row(1), c = positions.row(2), d = positions.row(3);
    if ((b - a).cross(c - a).dot(d - a) > 0) positions.row(1).swap(positions.row(2));
    const RestSurface surface = make_rest_surface(positions, triangles);
    for (int j = 0; j < 50; ++j) {
      const Vector3d p = random_point(random, 1.2);
      CHECK((nearest_point(surface, p, anywhere).distance > 0) == (largest_height(surface, p) > 0));
    }
  }
}

TEST_CASE("on a sharp ridge whose sides are both alike a point outside is outside") {
  const RestSurface roof = make_roof(1.2);  // 69 degrees: normals at 55 degrees from up
  Random random(6);
  for (int i = 0; i < 500; ++i) {
    const double x = random.uniform(-0.5, 0.5), y = random.uniform(0, 0.5), z = random.uniform(-0.8, 0.8);
    const SurfaceHit hit = nearest_alike(roof, {x, y, z}, Vector3d::UnitY(), 0.5, anywhere);
    REQUIRE(hit.triangle >= 0);
    CHECK(hit.distance > 0);
    CHECK(hit.distance == Approx(nearest_point(roof, {x, y, z}, anywhere).distance));
  }
}

TEST_CASE("needles do not turn the surface inside out") {
  const RestSurface surface = make_sphere_with_needles();
  for (int t = 0; t < int(surface.triangles.rows()); ++t) {
    const Eigen::RowVector3d out = corner_of(surface, t, 0).transpose().normalized();
    CHECK(surface.triangle_normals.row(t).dot(out) > 0.9);
    for (int k = 0; k < 3; ++k) {
      CHECK(surface.edge_normals.row(3 * t + k).dot(out) > 0.9);
      CHECK(surface.vertex_normals.row(surface.triangles(t, k)).dot(out) > 0.9);
    }
  }
  Random random(7);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d direction = random_point(random, 1).normalized();
    CHECK(nearest_point(surface, 0.98 * direction, anywhere).distance < 0);
    CHECK(nearest_point(surface, 1.02 * direction, anywhere).distance > 0);
  }
}

TEST_CASE("where the normals at an edge cancel a point on it has a triangle's") {
  Points positions(3, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 0, 1;
  Triangles triangles(2, 3);
  triangles << 0, 2, 1, 0, 1, 2;
  const RestSurface sheet = make_rest_surface(positions, triangles);
  for (const Vector3d& p : {Vector3d(0.5, 0, 0), Vector3d(0, 0, 0)})
    CHECK(nearest_point(sheet, p, anywhere).normal == Vector3d::UnitY());
}

TEST_CASE("a segment through an edge or a corner enters, and one that ends before it does not") {
  Random random(8);
  const RestSurface surface = make_rough_sphere(random);
  for (int t = 0; t < int(surface.triangles.rows()); ++t)
    for (const double share : {0.0, 0.3, 0.5}) {
      const Vector3d corner = corner_of(surface, t, 0), on = corner + share * (corner_of(surface, t, 1) - corner);
      const Vector3d inside = random_point(random, 0.3), way = on - inside;
      for (const double size : {1.0, 1e-2, 1e-5}) {
        CHECK(first_entered(surface, on + size * way, on - size * way) >= 0);
        CHECK(first_entered(surface, on - size * way, inside) == -1);
      }
    }
}

TEST_CASE("the normal is the gradient of the distance, with second order") {
  const TriangleMesh sphere = make_sphere(1, 3);
  const RestSurface surface = make_rest_surface(sphere.positions, sphere.triangles);
  Random random(3);
  int smooth = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = random_point(random, 1.4), direction = random_point(random, 1).normalized();
    const SurfaceHit hit = nearest_point(surface, p, anywhere);
    const auto difference = [&](double h) {
      const double above = nearest_point(surface, p + h * direction, anywhere).distance,
                   below = nearest_point(surface, p - h * direction, anywhere).distance;
      return (above - below) / (2 * h) - hit.normal.dot(direction);
    };
    const double coarse = std::abs(difference(1e-4)), fine = std::abs(difference(1e-5));
    if (coarse < 1e-6 && fine < 1e-6) ++smooth;  // elsewhere a ridge of the distance lies between
  }
  CHECK(smooth > 180);
}

TEST_CASE("a point that has come through a sheet is measured against the side that it came through") {
  const RestSurface sheet = make_sheet(0.01);
  const Vector3d above(0.1, 0.05, 0.1), through(0.1, -0.02, 0.1), inside(0.1, -0.003, 0.1);
  const int entered = first_entered(sheet, above, through);
  REQUIRE(entered >= 0);
  CHECK(sheet.triangle_normals(entered, 1) == Approx(1));
  CHECK(nearest_point(sheet, through, anywhere).distance == Approx(0.015));  // outside, below
  for (const Vector3d& point : {through, inside}) {
    const SurfaceHit hit = nearest_alike(sheet, point, Vector3d::UnitY(), 0.5, anywhere);
    CHECK(hit.distance == Approx(point.y() - 0.005));
    CHECK(hit.normal.y() == Approx(1));
  }
  CHECK(first_entered(sheet, through, Vector3d(0.1, -0.5, 0.1)) == -1);
  CHECK(first_entered(sheet, inside, above) == -1);  // it leaves
  CHECK(last_entered(sheet, above, through) == entered);
  CHECK(last_entered(sheet, inside, above) == -1);
}

TEST_CASE("a way through two sheets enters both") {
  const RestSurface sheet = make_sheet(0.01);
  const auto count = sheet.vertices.rows();
  Points vertices(2 * count, 3);
  vertices << sheet.vertices, sheet.vertices.rowwise() - Eigen::RowVector3d(0, 0.1, 0);
  Triangles triangles(2 * sheet.triangles.rows(), 3);
  triangles << sheet.triangles, sheet.triangles.array() + int(count);
  const RestSurface both = make_rest_surface(vertices, triangles);
  const Vector3d above(0.1, 0.05, 0.1), below(0.12, -0.2, 0.11);
  const int first = first_entered(both, above, below), last = last_entered(both, above, below);
  REQUIRE(first >= 0);
  REQUIRE(last >= 0);
  CHECK(corner_of(both, first, 0).y() == Approx(0.005));
  CHECK(corner_of(both, last, 0).y() == Approx(-0.095));
  CHECK(last_entered({both, 2}, 2 * above, 2 * below) == last);
}

TEST_CASE("vertices at one place are one, and triangles without area are none") {
  Points positions(5, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0;  // 1 and 3 are a seam
  Triangles triangles(3, 3);
  triangles << 0, 1, 2, 3, 4, 2, 1, 3, 4;
  const RestSurface surface = make_rest_surface(positions, triangles);
  CHECK(surface.triangles.rows() == 2);
  for (int row = 0; row < 6; ++row) CHECK(surface.edge_normals.row(row).z() == Approx(1));
  CHECK(nearest_point(make_rest_surface(Points(0, 3), Triangles(0, 3)), Vector3d::Zero(), anywhere).triangle == -1);
}

TEST_CASE("a surface at another size answers as one made at that size") {
  constexpr double scale = 3.7;
  Random random(5);
  const RestSurface surface = make_rough_sphere(random);
  const RestSurface larger = make_rest_surface(scale * surface.vertices, surface.triangles);
  const ScaledSurface scaled{surface, scale};
  for (int i = 0; i < 200; ++i) {
    const Vector3d point = scale * random_point(random, 1.3), to = scale * random_point(random, 1.3);
    const SurfaceHit hit = nearest_point(scaled, point, anywhere), expected = nearest_point(larger, point, anywhere);
    CHECK(hit.distance == Approx(expected.distance));
    CHECK((hit.point - expected.point).norm() < 1e-12);
    CHECK((hit.normal - expected.normal).norm() < 1e-9);
    CHECK((nearest_point(scaled, point, 0.1).triangle < 0) == (nearest_point(larger, point, 0.1).triangle < 0));
    CHECK(first_entered(scaled, point, to) == first_entered(larger, point, to));
    const Vector3d side = point.normalized();
    CHECK(nearest_alike(scaled, point, side, 0.5, 9).distance ==
          Approx(nearest_alike(larger, point, side, 0.5, 9).distance));
    const DistanceBounds bounds = distance_bounds(scaled, point);
    CHECK(bounds.low <= expected.distance);
    CHECK(bounds.high >= expected.distance);
  }
}

TEST_CASE("a view of distances through an affine map bounds those of the images, as a look-up at each does") {
  constexpr double scale = 2.3;
  Random random(6);
  const RestSurface surface = make_rough_sphere(random);
  const ScaledSurface scaled{surface, scale};
  Matrix3d linear;
  linear << 1.2, 0.3, 0, -0.2, 0.8, 0.1, 0.1, 0, 1.1;
  const Vector3d translation = random_point(random, 0.5);
  const DistanceView view = view_distances(scaled, linear, translation);
  for (int i = 0; i < 500; ++i) {
    const Vector3d image = scale * random_point(random, 1.3), point = linear.inverse() * (image - translation);
    const double low = least_distance(view, point);
    CHECK(low <= nearest_point(scaled, image, anywhere).distance);
    CHECK(low == Approx(distance_bounds(scaled, image).low).margin(1e-5));
  }
  const RestSurface moved = moved_surface(surface, surface.vertices);  // has no cache
  CHECK(least_distance(view_distances({moved, 1}, linear, translation), Vector3d::Zero()) == anywhere);
}
