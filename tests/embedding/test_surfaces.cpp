// Shapes, placement, reports and sampled distances.
#include <Eigen/Geometry>
#include <numbers>

#include "core/base/error.h"
#include "embedding/surface/distance_grid.h"
#include "embedding/surface/mesh_report.h"
#include "embedding/surface/placement.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;

namespace {

constexpr double pi = std::numbers::pi;

float value_at(const SampledDistance& grid, int i, int j, int k) {
  return grid.values[(std::size_t(i) * grid.size[1] + j) * grid.size[2] + k];
}

template <class Visit>
void for_each_sample(const SampledDistance& grid, Visit visit) {
  for (int i = 0; i < grid.size[0]; ++i)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int k = 0; k < grid.size[2]; ++k)
        visit(grid.origin + grid.spacing * Vector3d(i, j, k), double(value_at(grid, i, j, k)));
}

double box_distance(const Vector3d& p, const Vector3d& half) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

}  // namespace

TEST_CASE("shapes are watertight, face outwards and have the right volume") {
  const auto check = [](const TriangleMesh& mesh, double volume, double tolerance) {
    const MeshReport report = report_mesh(mesh);
    CHECK(report.watertight);
    CHECK(report.num_parts == 1);
    CHECK(report.problems.empty());
    CHECK(report.signed_volume == Approx(volume).epsilon(tolerance));
  };
  check(make_box({1, 2, 3}), 6, 1e-12);
  check(make_sphere(0.5), unit_sphere_volume / 8, 1e-3);
  check(make_cylinder(0.06, 1), pi * 0.0036, 2e-3);
  check(make_ring(0.5, 0.2), 2 * pi * 0.5 * pi * 0.01, 3e-3);
  const double rim = 65 * pi / 180, middle = 0.5 / std::sin(rim), half = 0.03;
  check(make_bowl(0.5, 2 * half),
        2 * pi * (1 - std::cos(rim)) / 3 * (std::pow(middle + half, 3) - std::pow(middle - half, 3)) +
            pi * half * half / 2 * 2 * pi * (0.5 + 4 * half / (3 * pi) * std::cos(rim)),  // Pappus: half a torus
        4e-3);
  CHECK(make_bowl(0.5, 0.06).positions.col(1).minCoeff() == Approx(0).margin(1e-12));
  CHECK(make_sphere(1).num_triangles() >= 20000);
  CHECK((make_sphere(2.5).positions.rowwise().norm().array() - 2.5).abs().maxCoeff() < 1e-14);
  CHECK(make_plane(4).normals.row(0)[1] == 1);
  CHECK_THROWS_AS(make_sphere(-1), Error);
  CHECK_THROWS_AS(make_box({1, 0, 1}), Error);
  CHECK_THROWS_AS(make_bowl(0.5, 2), Error);
  CHECK_THROWS_AS(make_ring(0.5, 1), Error);
}

TEST_CASE("a report counts a mesh's faults") {
  const TriangleMesh sphere = make_sphere(1, 2);
  SECTION("one triangle missing: three boundary edges") {
    TriangleMesh open = sphere;
    open.triangles.conservativeResize(sphere.num_triangles() - 1, 3);
    const MeshReport report = report_mesh(open);
    CHECK_FALSE(report.watertight);
    CHECK(report.num_boundary_edges == 3);
  }
  SECTION("one triangle turned: three edges disagree") {
    TriangleMesh turned = sphere;
    std::swap(turned.triangles(7, 0), turned.triangles(7, 1));
    CHECK(report_mesh(turned).num_inconsistent_edges == 3);
  }
  SECTION("one triangle twice: three edges with three triangles") {
    TriangleMesh doubled = sphere;
    doubled.triangles.conservativeResize(sphere.num_triangles() + 1, 3);
    doubled.triangles.bottomRows(1) = sphere.triangles.row(0);
    CHECK(report_mesh(doubled).num_non_manifold_edges == 3);
  }
  SECTION("parts, duplicates, inside out") {
    const MeshReport report = report_mesh(turned_inside_out(joined(sphere, moved(sphere, {5, 0, 0}))));
    CHECK(report.num_parts == 2);
    CHECK(report.signed_volume < 0);
    CHECK(report.problems.size() == 1);
    CHECK(report_mesh(joined(sphere, sphere)).num_duplicate_vertices == sphere.num_vertices());
  }
}

TEST_CASE("placement: unit, up axis, rotation, height, position, in that order") {
  TriangleMesh mesh;
  mesh.positions.resize(4, 3);
  mesh.positions << 0, 0, 0, 100, 0, 0, 0, 200, 0, 0, 0, 400;  // cm, z up
  mesh.triangles.resize(1, 3);
  mesh.triangles << 0, 1, 2;
  SECTION("z up in centimetres") {
    place(mesh, {.unit = 0.01, .up = "z"});
    CHECK((mesh.positions.row(3) - Eigen::RowVector3d(0, 4, 0)).norm() < 1e-14);
    CHECK((mesh.positions.row(2) - Eigen::RowVector3d(0, 0, -2)).norm() < 1e-14);
  }
  SECTION("x up stays right-handed") {
    place(mesh, {.up = "x"});
    CHECK((mesh.positions.row(1) - Eigen::RowVector3d(0, 100, 0)).norm() < 1e-12);
    Matrix3d frame;
    frame << mesh.positions.row(1) / 100, mesh.positions.row(2) / 200, mesh.positions.row(3) / 400;
    CHECK(frame.determinant() == Approx(1));
  }
  SECTION("about world X, then Y, then Z") {
    place(mesh, {.rotation_degrees = {90, 90, 0}});
    // y -> z -> x
    CHECK((mesh.positions.row(2) - Eigen::RowVector3d(200, 0, 0)).norm() < 1e-12);
  }
  SECTION("height after rotation, centre at the position") {
    place(mesh, {.up = "z", .height = 2.0, .rotation_degrees = {0, 0, 30}, .position = Vector3d(1, 2, 3)});
    const Eigen::RowVector3d low = mesh.positions.colwise().minCoeff(), high = mesh.positions.colwise().maxCoeff();
    CHECK(high[1] - low[1] == Approx(2).epsilon(1e-12));
    CHECK((0.5 * (low + high) - Eigen::RowVector3d(1, 2, 3)).norm() < 1e-12);
  }
  SECTION("what cannot be is refused") {
    CHECK_THROWS_AS(place(mesh, {.up = "w"}), Error);
    CHECK_THROWS_AS(place(mesh, {.height = -1.0}), Error);
    CHECK_THROWS_AS(place(mesh, {.scale = 0.0}), Error);
    CHECK_THROWS_AS(place(mesh, {.unit = std::nan("")}), Error);
    TriangleMesh sheet = make_plane(1);
    CHECK_THROWS_AS(place(sheet, {.height = 1.0}), Error);
  }
}

TEST_CASE("a sampled box has the box's distances") {
  const Vector3d size(1, 0.6, 0.8);
  const SampledDistance grid = make_distance_grid(make_box(size), {.max_samples_per_axis = 64});
  CHECK(grid.size.maxCoeff() == 64);
  double near_error = 0, far_error = 0;
  int wrong_signs = 0;
  for_each_sample(grid, [&](const Vector3d& p, double d) {
    const double exact = box_distance(p, size / 2);
    (std::abs(exact) < 2 * grid.spacing ? near_error : far_error) =
        std::max(std::abs(exact) < 2 * grid.spacing ? near_error : far_error, std::abs(d - exact));
    if (std::abs(exact) > 1e-5 && (d < 0) != (exact < 0)) ++wrong_signs;
  });
  CHECK(wrong_signs == 0);
  CHECK(near_error < 0.01 * grid.spacing);
  CHECK(far_error < 0.6 * grid.spacing);
}

TEST_CASE("an open mesh and overlapping parts keep their inside in the distance grid") {
  std::vector<std::string> notes;
  const TriangleMesh bowl = part_of(make_sphere(1), [](const Vector3d& p) { return p[1] < 0.5; });
  const SampledDistance grid = make_distance_grid(bowl, {.max_samples_per_axis = 48}, &notes);
  CHECK(!notes.empty());
  double inside = 0;
  for_each_sample(grid, [&](const Vector3d&, double d) { inside += d < 0 ? std::pow(grid.spacing, 3) : 0; });
  const double cap = pi * 0.25 * 2.5 / 3;
  CHECK(inside == Approx(unit_sphere_volume - cap).epsilon(0.02));
}

TEST_CASE("sharp edges of a box are sampled, smooth and concave ones are not") {
  const Points points = sharp_edge_points(make_box({1, 1, 1}), {.spacing = 0.01});
  REQUIRE(points.rows() > 12 * 90);
  int corners = 0;
  for (const auto& p : points.rowwise()) {
    const int on_faces = int((p.cwiseAbs().array() > 0.5 - 1e-12).count());
    CHECK(on_faces >= 2);
    corners += on_faces == 3;
  }
  CHECK(corners == 8);
  CHECK(sharp_edge_points(make_sphere(1, 3)).rows() == 0);
  CHECK(sharp_edge_points(turned_inside_out(make_box({1, 1, 1}))).rows() == 0);
}
