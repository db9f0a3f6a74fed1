#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "embedding/figure/figure.h"
#include "tests/support/catch.h"

namespace {

using namespace umax;

const TriangleMesh& figure_mesh() {
  static const TriangleMesh mesh = make_figure();
  return mesh;
}

template <class Matrix>
bool same_bytes(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), sizeof(*a.data()) * std::size_t(a.size())) == 0;
}

bool same_bytes(const TriangleMesh& a, const TriangleMesh& b) {
  return same_bytes(a.positions, b.positions) && same_bytes(a.triangles, b.triangles) &&
         same_bytes(a.normals, b.normals) && same_bytes(a.colors, b.colors);
}

TriangleMesh figure_with_threads(std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return make_figure();
}

/// Directed edges, sorted.
std::vector<std::pair<int, int>> directed_edges(const TriangleMesh& mesh) {
  std::vector<std::pair<int, int>> edges;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) edges.emplace_back(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3));
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

int num_components(const TriangleMesh& mesh) {
  std::vector<int> parent(std::size_t(mesh.num_vertices()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [a, b] : directed_edges(mesh)) parent[root(a)] = root(b);
  int components = 0;
  for (int v = 0; v < int(parent.size()); ++v) components += root(v) == v;
  return components;
}

/// Triangles that meet a vertex, walked from one to the next around it; less than all of them: the vertex joins two
/// fans.
bool one_fan_around_every_vertex(const TriangleMesh& mesh) {
  std::vector<std::vector<std::pair<int, int>>> spokes(
      std::size_t(mesh.num_vertices()));  // (next, previous) per triangle
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) {
      spokes[mesh.triangles(t, k)].emplace_back(mesh.triangles(t, (k + 1) % 3), mesh.triangles(t, (k + 2) % 3));
    }
  }
  return std::all_of(spokes.begin(), spokes.end(), [](const auto& around) {
    if (around.empty()) return false;
    int at = around.front().second;
    std::size_t walked = 1;
    while (at != around.front().first && walked <= around.size()) {
      const auto next =
          std::find_if(around.begin(), around.end(), [&](const auto& spoke) { return spoke.first == at; });
      if (next == around.end()) return false;
      at = next->second;
      ++walked;
    }
    return walked == around.size();
  });
}

struct Corners {
  Vector3d a, b, c;
  Vector3d area_vector() const { return 0.5 * (b - a).cross(c - a); }
  /// 1 for an equilateral triangle, 0 for a degenerate one
  double quality() const {
    const double edges = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    return 4 * std::sqrt(3.0) * area_vector().norm() / edges;
  }
};

Corners corners(const TriangleMesh& mesh, Eigen::Index t) {
  const auto corner = [&](int k) { return Vector3d(mesh.positions.row(mesh.triangles(t, k)).transpose()); };
  return {corner(0), corner(1), corner(2)};
}

double enclosed_volume(const TriangleMesh& mesh) {
  double volume = 0;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Corners tri = corners(mesh, t);
    volume += tri.a.dot(tri.b.cross(tri.c)) / 6;
  }
  return volume;
}

}  // namespace

TEST_CASE("the figure stands 2 m tall on the ground and has between 100,000 and 250,000 triangles") {
  const TriangleMesh& mesh = figure_mesh();
  CHECK(mesh.num_triangles() >= 100000);
  CHECK(mesh.num_triangles() <= 250000);
  CHECK(mesh.positions.allFinite());
  CHECK(mesh.positions.col(1).minCoeff() == 0.0);
  CHECK(mesh.positions.col(1).maxCoeff() == Approx(2.0).epsilon(1e-12));
}

TEST_CASE("the figure's soles carry it: vertices of both feet touch the ground on every side of the centre of volume") {
  const TriangleMesh& mesh = figure_mesh();
  Vector3d centre = Vector3d::Zero();
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Corners tri = corners(mesh, t);
    centre += tri.a.dot(tri.b.cross(tri.c)) / 24 * (tri.a + tri.b + tri.c);
  }
  centre /= enclosed_volume(mesh);
  Eigen::AlignedBox3d sole;
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.positions(v, 1) < 0.005) sole.extend(mesh.positions.row(v).transpose());
  }
  CHECK(sole.min().x() < -0.2);
  CHECK(sole.max().x() > 0.2);
  CHECK(sole.min().z() < centre.z());
  CHECK(sole.max().z() > centre.z());
}

TEST_CASE("the figure is one closed, manifold, outward surface") {
  const TriangleMesh& mesh = figure_mesh();
  REQUIRE(mesh.triangles.minCoeff() == 0);
  REQUIRE(mesh.triangles.maxCoeff() == mesh.num_vertices() - 1);
  const auto edges = directed_edges(mesh);
  CHECK(std::adjacent_find(edges.begin(), edges.end()) == edges.end());
  const auto has_twin = [&](const auto& edge) {
    return std::binary_search(edges.begin(), edges.end(), std::make_pair(edge.second, edge.first));
  };
  CHECK(std::all_of(edges.begin(), edges.end(), has_twin));
  CHECK(one_fan_around_every_vertex(mesh));
  CHECK(num_components(mesh) == 1);
  // no handles and no tunnels: V - E + F of a sphere
  CHECK(mesh.num_vertices() - Eigen::Index(edges.size()) / 2 + mesh.num_triangles() == 2);
  CHECK(enclosed_volume(mesh) > 0.4);
  CHECK(enclosed_volume(mesh) < 0.8);
}

TEST_CASE("the figure's face has smaller triangles than its body") {
  const TriangleMesh& mesh = figure_mesh();
  double face = 0, body = 0;
  Eigen::Index in_face = 0, in_body = 0;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Corners tri = corners(mesh, t);
    const double area = tri.area_vector().norm();
    const bool nose = tri.a.z() > 0.45 && tri.a.y() > 1.1;
    (nose ? face : body) += area;
    ++(nose ? in_face : in_body);
  }
  REQUIRE(in_face > 500);
  CHECK(face / double(in_face) < 0.4 * body / double(in_body));
}

TEST_CASE("the figure's triangles are well shaped") {
  const TriangleMesh& mesh = figure_mesh();
  std::vector<double> quality;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) quality.push_back(corners(mesh, t).quality());
  std::sort(quality.begin(), quality.end());
  CHECK(quality.front() > 1e-3);
  CHECK(quality[quality.size() / 1000] > 0.3);
  CHECK(quality[quality.size() / 2] > 0.85);
}

TEST_CASE("the figure's normals are unit and agree with its triangles, its colours are reflectances") {
  const TriangleMesh& mesh = figure_mesh();
  REQUIRE(mesh.normals.rows() == mesh.num_vertices());
  REQUIRE(mesh.colors.rows() == mesh.num_vertices());
  CHECK((mesh.normals.rowwise().norm().array() - 1).abs().maxCoeff() < 1e-12);
  CHECK(mesh.colors.minCoeff() >= 0);
  CHECK(mesh.colors.maxCoeff() <= 1);
  Eigen::Index agreeing = 0;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Vector3d mean = mesh.normals(mesh.triangles.row(t), Eigen::all).colwise().sum().transpose();
    agreeing += corners(mesh, t).area_vector().dot(mean) > 0;
  }
  CHECK(double(agreeing) > 0.999 * double(mesh.num_triangles()));
}

TEST_CASE("the figure is painted in several colours: dark plates, light belly, warm skin") {
  const TriangleMesh& mesh = figure_mesh();
  Eigen::Index dark = 0, light = 0, warm = 0;
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v) {
    const auto color = mesh.colors.row(v);
    dark += color.maxCoeff() < 0.3;
    light += color.minCoeff() > 0.3;
    warm += color.x() > 2 * color.z() && color.x() > 0.4;
  }
  CHECK(double(dark) > 0.15 * double(mesh.num_vertices()));
  CHECK(double(light) > 0.02 * double(mesh.num_vertices()));
  CHECK(double(warm) > 0.25 * double(mesh.num_vertices()));
}

TEST_CASE("the figure is the same, byte for byte, every time and for any number of threads") {
  CHECK(same_bytes(figure_with_threads(1), figure_mesh()));
  CHECK(same_bytes(figure_with_threads(2), figure_mesh()));
}

TEST_CASE(
    "the figure is a pair of halves up to its pose: head and one arm turned, below them left and right are twins") {
  const TriangleMesh& mesh = figure_mesh();
  const auto half_below_belly = [&](double side) {
    Points points(mesh.num_vertices(), 3);
    Eigen::Index count = 0;
    for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::RowVector3d p = mesh.positions.row(v);
      if (p.y() < 0.8 && side * p.x() > 0) points.row(count++) = p;
    }
    return Points(points.topRows(count));
  };
  const Points right = half_below_belly(1), left = half_below_belly(-1);
  REQUIRE(right.rows() > 10000);
  CHECK(double(right.rows()) == Approx(double(left.rows())).epsilon(0.01));
  CHECK(right.col(0).mean() == Approx(-left.col(0).mean()).margin(1e-3));
  CHECK(right.col(1).mean() == Approx(left.col(1).mean()).margin(1e-3));
  CHECK(right.col(2).mean() == Approx(left.col(2).mean()).margin(1e-3));
  CHECK(right.col(0).maxCoeff() == Approx(-left.col(0).minCoeff()).margin(2e-3));
}

TEST_CASE("a figure of another height is the same figure scaled") {
  const TriangleMesh small = make_figure({.height = 0.5});
  CHECK(same_bytes(small.triangles, figure_mesh().triangles));
  CHECK((4 * small.positions - figure_mesh().positions).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("the figure refuses heights and cell sizes that make no figure") {
  CHECK_THROWS_AS(make_figure({.height = 0}), Error);
  CHECK_THROWS_AS(make_figure({.height = std::nan("")}), Error);
  CHECK_THROWS_AS(make_figure({.cell_size = 1e-4}), Error);
  CHECK_THROWS_AS(make_figure({.cell_size = 1}), Error);
}
