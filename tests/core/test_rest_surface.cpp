// The exact rest surface: nearest points, signs, sides and bounds.
#include "core/model/rest_surface.h"

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

// distance to a triangle by brute force over a fine net of its points, from above
double sampled_distance(const TriangleMesh& mesh, Eigen::Index t, const Vector3d& p) {
  constexpr int fine = 60;
  double least = anywhere;
  for (int i = 0; i <= fine; ++i)
    for (int j = 0; i + j <= fine; ++j) {
      const Eigen::RowVector3d q =
          (i * mesh.positions.row(mesh.triangles(t, 0)) + j * mesh.positions.row(mesh.triangles(t, 1)) +
           (fine - i - j) * mesh.positions.row(mesh.triangles(t, 2))) /
          fine;
      least = std::min(least, (q.transpose() - p).norm());
    }
  return least;
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
  const TriangleMesh sphere = make_sphere(1, 1);  // 80 triangles
  const RestSurface surface = make_rest_surface(sphere.positions, sphere.triangles);
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Vector3d p = random_point(random, 1.5);
    double least = anywhere;
    for (Eigen::Index t = 0; t < sphere.triangles.rows(); ++t) least = std::min(least, sampled_distance(sphere, t, p));
    const double found = std::abs(nearest_point(surface, p, anywhere).distance);
    CHECK(found <= least + 1e-12);
    CHECK(found > least - 0.02);  // the net's spacing
  }
  CHECK(nearest_point(surface, {3, 0, 0}, 1.9).triangle == -1);
  CHECK(nearest_point(surface, {3, 0, 0}, 2.1).triangle >= 0);
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
