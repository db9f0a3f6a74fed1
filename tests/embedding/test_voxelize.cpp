#include <ctime>
#include <numbers>

#include "core/base/error.h"
#include "embedding/embedding.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/placement.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"
#include "tests/support/model_file.h"

using namespace umax;
using namespace umax::testing;

namespace {

constexpr double pi = std::numbers::pi;

double filled_volume(const Lattice& lattice) {
  return lattice.filled_fraction.sum() * lattice.cell_size.prod();
}

}  // namespace

TEST_CASE("the cage holds every vertex of a mesh, whatever its size") {
  const TriangleMesh mesh = blob(GENERATE(range(10u, 16u)), 3);
  for (const CageOptions& options : {CageOptions{.size = 40}, CageOptions{.size = 700}, CageOptions{.size = 0.17},
                                     CageOptions{.size = Vector3i(5, 3, 7)}}) {
    CageReport report;
    const Lattice lattice = voxelize(mesh, options, &report);
    CHECK_NOTHROW(embed(mesh, lattice));
    CHECK_NOTHROW(validate(lattice));
    CHECK(report.num_islands == 1);
    CHECK(report.notes.empty());
    CHECK(report.filled_volume == Approx(report.mesh_volume).epsilon(0.01));
  }
}

TEST_CASE("the cage touches or fills: no cell of it is empty") {
  const Lattice lattice = voxelize(make_sphere(1), {.size = 500});
  CHECK(lattice.num_hexes() >= 480);
  CHECK(lattice.num_hexes() <= 520);
  CHECK(lattice.filled_fraction.minCoeff() >= 0);
  CHECK(lattice.filled_fraction.maxCoeff() <= 1);
  // the point of every cell nearest to the centre lies in the sphere
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Vector3d low = lattice.rest_positions.row(lattice.hexes(e, 0)),
                   high = lattice.rest_positions.row(lattice.hexes(e, 7));
    CHECK(Vector3d::Zero().cwiseMax(low).cwiseMin(high).norm() < 1);
  }
}

TEST_CASE("27 cells around a sphere are the cube of its bounding box") {
  const Lattice lattice = voxelize(make_sphere(1), {.size = 27});
  CHECK(lattice.num_hexes() == 27);
  CHECK(lattice.cell_size[0] == Approx(2.0 / 3).epsilon(1e-12));
  CHECK(filled_volume(lattice) == Approx(unit_sphere_volume).epsilon(0.01));
}

TEST_CASE("a grid of the bounding box fits it exactly") {
  const TriangleMesh beam = make_cylinder(0.06, 1);
  const Lattice lattice = voxelize(beam, {.size = Vector3i(14, 2, 2), .whole_box = true});
  REQUIRE(lattice.num_hexes() == 56);
  CHECK(lattice.num_nodes() == 135);
  CHECK(lattice.cell_size[0] == Approx(1.0 / 14).epsilon(1e-14));
  CHECK(lattice.cell_size[1] == Approx(0.06).epsilon(1e-12));
  CHECK(lattice.rest_positions.col(0).minCoeff() == -0.5);
  CHECK(lattice.rest_positions.col(0).maxCoeff() == Approx(0.5).epsilon(1e-15));
  CHECK(filled_volume(lattice) == Approx(pi * 0.0036).epsilon(0.01));
  CHECK_NOTHROW(embed(beam, lattice));
}

TEST_CASE("a box that lies on grid planes gets just the cells it fills") {
  const TriangleMesh box = make_box({3, 2, 1});
  const Lattice lattice = voxelize(box, {.size = 0.5});
  CHECK(lattice.num_hexes() == 6 * 4 * 2);
  CHECK(filled_volume(lattice) == Approx(6).epsilon(1e-6));

  // an L of two boxes whose inner faces lie on grid planes
  const TriangleMesh bend = joined(make_box({1, 3, 1}), moved(make_box({2, 1, 1}), {1.5, -1, 0}));
  CHECK(voxelize(bend, {.size = 0.5}).num_hexes() == (2 * 6 + 4 * 2) * 2);
}

TEST_CASE("a flat sheet gets one layer of cells") {
  const Lattice lattice = voxelize(make_plane(2), {.size = 0.25});
  CHECK(lattice.num_hexes() == 64);
  CHECK(filled_volume(lattice) < 1e-9);
}

TEST_CASE("meshes with faults are filled as they look, and the report says so") {
  const TriangleMesh sphere = make_sphere(1);
  CageReport report;
  SECTION("open: a hole much wider than a voxel") {
    const double lid = 0.8, cap = pi * (1 - lid) * (1 - lid) * (2 + lid) / 3;
    const TriangleMesh open = part_of(sphere, [&](const Vector3d& p) { return p[1] < lid; });
    const Lattice lattice = voxelize(open, {.size = 400}, &report);
    CHECK(filled_volume(lattice) == Approx(unit_sphere_volume - cap).epsilon(0.02));
    CHECK(report.method == "winding numbers");
    REQUIRE(report.notes.size() >= 2);
    CHECK(report.notes[0].find("open") != std::string::npos);
  }
  SECTION("open: a tube without ends") {
    const TriangleMesh tube = part_of(make_cylinder(0.2, 1), [](const Vector3d& p) { return std::abs(p[0]) < 0.4999; });
    CHECK(filled_volume(voxelize(tube, {.size = 400}, &report)) == Approx(pi * 0.04).epsilon(0.02));
    CHECK(report.notes[0].find("2 holes") != std::string::npos);
  }
  SECTION("self-intersecting: two spheres that overlap count once") {
    const TriangleMesh two = joined(sphere, moved(sphere, {1, 0, 0}));
    const double lens = pi * 5 / 12;
    CHECK(filled_volume(voxelize(two, {.size = 400}, &report)) == Approx(2 * unit_sphere_volume - lens).epsilon(0.01));
    CHECK(!report.notes.empty());
  }
  SECTION("multi-part: two spheres apart") {
    const TriangleMesh two = joined(sphere, moved(sphere, {3, 0, 0}));
    const Lattice lattice = voxelize(two, {.size = 400}, &report);
    CHECK(filled_volume(lattice) == Approx(2 * unit_sphere_volume).epsilon(0.01));
    CHECK(report.num_islands == 2);
    const std::string half = std::to_string(lattice.num_hexes() / 2);
    REQUIRE(!report.notes.empty());
    CHECK(report.notes.back().find("2 pieces that share no node, the largest of " + half + " of ") !=
          std::string::npos);
    CHECK(report.notes.back().find("larger (fewer) cells") != std::string::npos);
  }
  SECTION("multi-part: one of them inside out") {
    const TriangleMesh two = joined(sphere, moved(turned_inside_out(sphere), {3, 0, 0}));
    CHECK(filled_volume(voxelize(two, {.size = 400}, &report)) == Approx(2 * unit_sphere_volume).epsilon(0.01));
  }
  SECTION("hollow: a ball with a cavity") {
    TriangleMesh cavity = turned_inside_out(sphere);
    cavity.positions *= 0.6;
    const Lattice lattice = voxelize(joined(sphere, cavity), {.size = 3000}, &report);
    CHECK(filled_volume(lattice) == Approx(unit_sphere_volume * (1 - 0.216)).epsilon(0.01));
  }
  SECTION("inside out as a whole") {
    CHECK(filled_volume(voxelize(turned_inside_out(sphere), {.size = 300})) ==
          Approx(unit_sphere_volume).epsilon(0.01));
  }
  SECTION("every second triangle faces the wrong way") {
    TriangleMesh mixed = sphere;
    for (Eigen::Index t = 0; t < mixed.num_triangles(); t += 2) std::swap(mixed.triangles(t, 1), mixed.triangles(t, 2));
    CHECK(filled_volume(voxelize(mixed, {.size = 300}, &report)) == Approx(unit_sphere_volume).epsilon(0.01));
    CHECK(!report.notes.empty());
  }
  SECTION("non-manifold: a wall inside, three triangles on its rim") {
    TriangleMesh wall = part_of(sphere, [](const Vector3d& p) { return p[1] > 0; });
    TriangleMesh walled = joined(sphere, wall);  // its upper half doubled
    CHECK(filled_volume(voxelize(walled, {.size = 300}, &report)) == Approx(unit_sphere_volume).epsilon(0.02));
  }
  SECTION("cracked: no two triangles share a vertex") {
    TriangleMesh soup;
    soup.positions.resize(3 * sphere.num_triangles(), 3);
    soup.triangles.resize(sphere.num_triangles(), 3);
    for (int t = 0; t < int(sphere.num_triangles()); ++t)
      for (int k = 0; k < 3; ++k) {
        soup.positions.row(3 * t + k) = sphere.positions.row(sphere.triangles(t, k)) * (1 + 1e-6 * (t % 7));
        soup.triangles(t, k) = 3 * t + k;
      }
    CHECK(filled_volume(voxelize(soup, {.size = 300}, &report)) == Approx(unit_sphere_volume).epsilon(0.01));
    CHECK(report.method == "level set");
  }
}

TEST_CASE("thousands of long triangles in one place cost a cage little, and it stays what it is without them") {
  const TriangleMesh box = make_box({1, 2, 3});
  const int first = int(box.num_vertices());
  TriangleMesh copied = box;
  copied.positions.conservativeResize(first + 3, 3);
  copied.positions.bottomRows(3) << -0.5, -1, -1.5, -0.5, -0.98, -1.5, -0.5, -1, 1.5;
  constexpr int num_pairs = 20000;
  copied.triangles.conservativeResize(box.num_triangles() + 2 * num_pairs, 3);
  for (int k = 0; k < num_pairs; ++k) {
    copied.triangles.row(box.num_triangles() + 2 * k) << first, first + 1, first + 2;
    copied.triangles.row(box.num_triangles() + 2 * k + 1) << first, first + 2, first + 1;
  }
  const CageOptions options{.size = 0.5};
  const std::clock_t start = std::clock();
  const Lattice cage = voxelize(copied, options);
  CHECK(double(std::clock() - start) / CLOCKS_PER_SEC < 3);  // of all threads; each triangle by itself took 19
  CHECK(cage.cells == voxelize(box, options).cells);
}

TEST_CASE("cages that cannot be are refused before memory is taken") {
  const TriangleMesh sphere = make_sphere(1, 3);
  const auto refuses = [&](const CageOptions& options) {
    try {
      voxelize(sphere, options);
    } catch (const Error& error) {
      return error.fault() == Fault::bad_data;
    }
    return false;
  };
  CHECK(refuses({.size = 0}));
  CHECK(refuses({.size = -5}));
  CHECK(refuses({.size = 5000001}));
  CHECK(refuses({.size = 0.0}));
  CHECK(refuses({.size = -0.1}));
  CHECK(refuses({.size = std::nan("")}));
  CHECK(refuses({.size = 1e-9}));
  CHECK(refuses({.size = 0.009}));
  CHECK(refuses({.size = Vector3i(3, 0, 3)}));
  CHECK(refuses({.size = Vector3i(30000, 30000, 30000)}));
  CHECK(refuses({.size = Vector3i(200, 200, 200), .whole_box = true}));
  CHECK_THROWS_AS(voxelize(TriangleMesh{}, {}), Error);
}

TEST_CASE("the armadillo at 2 m and 365 cells gives 355 to 375 in one piece", "[models]") {
  TriangleMesh mesh = load_mesh(test::model_file("armadillo.obj")).mesh;
  place(mesh, {.height = 2.0});
  CageReport report;
  const Lattice lattice = voxelize(mesh, {.size = 365}, &report);
  CHECK(lattice.num_hexes() >= 355);
  CHECK(lattice.num_hexes() <= 375);
  CHECK(report.num_loose_parts == 1);
  CHECK(report.method == "level set");
  CHECK(report.filled_volume == Approx(report.mesh_volume).epsilon(0.01));
  CHECK_NOTHROW(embed(mesh, lattice));
}
