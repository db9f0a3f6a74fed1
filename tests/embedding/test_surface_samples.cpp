// Points between the vertices of coarse surfaces; how thin walls are.
#include "embedding/surface/surface_samples.h"

#include <set>

#include "embedding/figure/figure.h"
#include "embedding/surface/shapes.h"
#include "embedding/surface/wall_thickness.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;

namespace {

RestSurface surface_of(const TriangleMesh& mesh) {
  return make_rest_surface(mesh.positions, mesh.triangles);
}

/// A closed prism along z of one unit: its section is a triangle of this height over a base of 2.
RestSurface make_tent(double height) {
  Points corners(6, 3);
  corners << -1, 0, 0, 1, 0, 0, 0, height, 0, -1, 0, 1, 1, 0, 1, 0, height, 1;
  Triangles triangles(8, 3);
  triangles << 0, 2, 1, 3, 4, 5, 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4, 2, 0, 3, 2, 3, 5;
  return make_rest_surface(corners, triangles);
}

/// Farthest point of the triangles from the nearest of the points.
double largest_hole(const RestSurface& surface, const Points& points) {
  double largest = 0;
  constexpr int parts = 40;
  for (int t = 0; t < int(surface.triangles.rows()); ++t)
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; i + j <= parts; ++j) {
        const Vector3d p =
            (i * corner_of(surface, t, 0) + j * corner_of(surface, t, 1) + (parts - i - j) * corner_of(surface, t, 2)) /
            parts;
        largest = std::max(largest, (points.rowwise() - p.transpose()).rowwise().norm().minCoeff());
      }
  return largest;
}

Points with_vertices(const Points& points, const RestSurface& surface) {
  Points all(points.rows() + surface.vertices.rows(), 3);
  all << surface.vertices, points;
  return all;
}

}  // namespace

TEST_CASE("points between the vertices of a coarse surface lie on it, nowhere twice, and leave no holes") {
  const double height = GENERATE(0.05, 1.0, 4.0);
  const RestSurface tent = make_tent(height);
  const SurfaceSampling sampling{.spacing = 0.1, .ridge_depth = 0.01, .num_given = tent.vertices.rows()};
  const Points points = sample_between_vertices(tent, sampling);
  REQUIRE(points.rows() > 0);
  const Points all = with_vertices(points, tent);
  std::set<std::array<double, 3>> places;
  double farthest = 0, nearest = 1;
  for (Eigen::Index i = 0; i < all.rows(); ++i) {
    places.insert({all(i, 0), all(i, 1), all(i, 2)});
    farthest = std::max(farthest, std::abs(nearest_point(tent, all.row(i).transpose(), 1).distance));
    for (Eigen::Index j = 0; j < i; ++j) nearest = std::min(nearest, (all.row(i) - all.row(j)).norm());
  }
  CHECK(places.size() == std::size_t(all.rows()));
  CHECK(farthest < 1e-14);
  CHECK(nearest > 1e-4);
  CHECK(largest_hole(tent, all) < 0.1);
}

TEST_CASE("another ridge across one goes no deeper between its points than it may") {
  const double height = GENERATE(0.1, 0.5, 1.0, 3.0);
  const RestSurface tent = make_tent(height);
  constexpr double depth = 0.004;
  const Points points = sample_between_vertices(tent, {.spacing = 0.1, .ridge_depth = depth, .num_given = 6});
  std::set<double> along;  // of points on the ridge
  for (const auto& p : points.rowwise())
    if (std::abs(p.y() - height) < 1e-12) along.insert(p.z());
  along.insert({0, 1});
  double widest = 0, last = 0;
  for (const double z : along) {
    widest = std::max(widest, z - last);
    last = z;
  }
  const double slope = std::sin(std::atan(height));  // its sides' and the other ridge's
  CHECK(widest / 2 * slope <= depth * (1 + 1e-9));
  CHECK(widest <= 0.1);
  CHECK(widest > 0.9 * std::min(0.1, 2 * depth / slope));  // and no more points than that takes
}

TEST_CASE("a surface that is fine beside its spacing gets no points, and a number that follows its area else") {
  const RestSurface figure = surface_of(make_figure());
  CHECK(sample_between_vertices(figure, {.spacing = 0.08, .ridge_depth = 3.2e-3, .num_given = figure.vertices.rows()})
            .rows() == 0);
  // a sliver as long as a thousand spacings and as wide as one
  Points corners(4, 3);
  corners << 0, 0, 0, 100, 0, 0, 100, 0.1, 0, 0, 0.1, 0;
  Triangles triangles(2, 3);
  triangles << 0, 1, 2, 0, 2, 3;
  const Points points = sample_between_vertices(make_rest_surface(corners, triangles),
                                                {.spacing = 0.1, .ridge_depth = 0.05, .num_given = 4});
  CHECK(points.rows() >= 3000);
  CHECK(points.rows() < 6000);
}

TEST_CASE("beside flat cells points lie closer across them than along them") {
  const RestSurface tent = make_tent(0.05);
  const Vector3d cells_per_metre(4, 200, 4);
  const SurfaceSampling sampling{.spacing = 0.25,
                                 .ridge_depth = 0.002,
                                 .num_given = tent.vertices.rows(),
                                 .to_cells = cells_per_metre.asDiagonal()};
  const Points points = with_vertices(sample_between_vertices(tent, sampling), tent);
  const RestSurface in_cells = make_rest_surface(tent.vertices * sampling.to_cells, tent.triangles);
  CHECK(largest_hole(in_cells, points * sampling.to_cells) < 0.25);
  CHECK(points.rows() < 8000);  // a quarter of the flat edge apart they would be 300,000
}

TEST_CASE("corners that are not given are among the points, once") {
  const RestSurface tent = make_tent(1);
  const SurfaceSampling given{.spacing = 10, .ridge_depth = 10, .num_given = 6};
  CHECK(sample_between_vertices(tent, given).rows() == 0);
  SurfaceSampling four = given;
  four.num_given = 4;
  const Points points = sample_between_vertices(tent, four);
  REQUIRE(points.rows() == 2);
  CHECK(points.row(0) == tent.vertices.row(4));
  CHECK(points.row(1) == tent.vertices.row(5));
}

TEST_CASE("the thickness of walls is that between their sides, tips left out, and nothing where all is thicker") {
  CHECK(wall_thickness(surface_of(make_bowl(1, 0.06)), 0.1) == Approx(0.06).epsilon(0.2));  // a little less at its rim
  CHECK(wall_thickness(surface_of(make_box({1, 0.01, 1})), 0.1) == Approx(0.01));
  CHECK(std::isinf(wall_thickness(surface_of(make_bowl(1, 0.06)), 0.04)));
  CHECK(std::isinf(wall_thickness(surface_of(make_sphere(1)), 0.5)));
  CHECK(std::isinf(wall_thickness(make_tent(4), 0.1)));
  // two boxes with a gap of air between them
  TriangleMesh boxes = make_box({1, 1, 1});
  const Eigen::Index count = boxes.num_vertices(), triangles = boxes.num_triangles();
  boxes.positions.conservativeResize(2 * count, 3);
  boxes.positions.bottomRows(count) = boxes.positions.topRows(count).rowwise() + Eigen::RowVector3d(0, 1.02, 0);
  boxes.triangles.conservativeResize(2 * triangles, 3);
  boxes.triangles.bottomRows(triangles) = boxes.triangles.topRows(triangles).array() + int(count);
  CHECK(std::isinf(wall_thickness(surface_of(boxes), 0.1)));
}
