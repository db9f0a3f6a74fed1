// The measure that judges contact between bodies must itself be right: depths that are known.
#include "tests/support/penetration.h"

#include <tbb/global_control.h>

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

struct Caged {
  Body body;
  Triangles triangles;
};

// in a block of cubes around the mesh, at least half a cell away from it
Caged in_cage(const TriangleMesh& mesh, double cell) {
  const Vector3d low = mesh.positions.colwise().minCoeff(), high = mesh.positions.colwise().maxCoeff();
  const Vector3i cells = ((high - low) / cell).array().ceil().cast<int>() + 1;
  Caged caged;
  caged.triangles = mesh.triangles;
  caged.body = make_block(cells, low - Vector3d::Constant(0.5 * cell), cell);
  caged.body.surface_rest = mesh.positions;
  caged.body.surface = embed_in_box(caged.body.lattice, cells, mesh.positions);
  return caged;
}

// a model with its bodies ready to be measured
struct Measured {
  Model model;
  std::vector<MeasuredBody> bodies;

  explicit Measured(const std::vector<Caged>& list, const MeasureOptions& options = {},
                    const std::vector<BodyPair>& pairs = {}) {
    std::vector<Body> described;
    for (const Caged& caged : list) described.push_back(caged.body);
    model = make_model(described, {}, pairs);
    for (int i = 0; i < int(list.size()); ++i) bodies.push_back(measured_body(model, i, list[i].triangles, options));
  }

  PenetrationReport at(const Points& nodes) const { return measure_penetration(model, bodies, nodes); }
  PenetrationReport at_rest() const { return at(model.rest_positions); }

  // every node moved by the map
  template <class Map>
  PenetrationReport mapped(const Map& map) const {
    Points nodes = model.rest_positions;
    for (auto node : nodes.rowwise()) node = map(Vector3d(node.transpose())).transpose();
    return at(nodes);
  }
};

void check_nothing(const PenetrationReport& report) {
  CHECK(report.between.depth == 0);
  CHECK(report.within.depth == 0);
  CHECK(report.crossing.depth == 0);
  CHECK(report.points_inside == 0);
  CHECK(report.edges_crossing == 0);
}

// a bar of 40 x 2 x 2 cells of 5 cm along x, with four triangles' edges to a cell
Measured make_bar() {
  return Measured({in_cage(box_mesh({0, 0, 0}, {2, 0.1, 0.1}, {160, 8, 8}), 0.05)});
}

// bends that bar into a ring about z of so many radians
Vector3d ring(const Vector3d& p, double turn) {
  const double radius = 2 / turn - (p[1] - 0.05), angle = p[0] / 2 * turn;
  return {radius * std::sin(angle), -radius * std::cos(angle), p[2]};
}

// folds that bar at x = 1 by an angle about its upper edge there, y = 0.1, in the two cells beside
Vector3d fold(const Vector3d& p, double angle) {
  const double share = std::clamp((p[0] - 0.95) / 0.1, 0.0, 1.0), middle = std::abs(share - 0.5) < 1e-9 ? 1 : p[0];
  const Matrix3d turn = Eigen::AngleAxisd(share * angle, Vector3d::UnitZ()).toRotationMatrix();
  const Vector3d hinge(1, 0.1, 0);
  return hinge + turn * (Vector3d(middle, p[1], p[2]) - hinge);
}

}  // namespace

TEST_CASE("two boxes overlap by as much as one was pushed into the other, however they are turned") {
  const Measured boxes({in_cage(box_mesh({0, 0, 0}, {1, 1, 1}, {16, 16, 16}), 0.25),
                        in_cage(box_mesh({0.9, 0.3, 0.3}, {1.26, 0.7, 0.7}, {8, 8, 8}), 0.1)});
  const Matrix3d turn = Random(3).rotation();
  for (const Matrix3d& rotation : {Matrix3d(Matrix3d::Identity()), turn}) {
    const PenetrationReport report = boxes.mapped([&](const Vector3d& p) -> Vector3d { return rotation * p; });
    CHECK(report.between.depth == Approx(0.1));
    CHECK(report.between.cells == Approx(1));  // of the finer body
    CHECK(report.between.body == 1);
    CHECK(report.between.other == 0);
    CHECK((rotation.transpose() * report.between.place)[0] == Approx(0.9));
    CHECK(report.points_inside >= 9 * 9);
    CHECK(report.edges_crossing > 0);
    CHECK(report.crossing.depth == Approx(0.0125));  // a vertex of the large one at 5/16
    CHECK(report.within.depth == 0);
  }
}

TEST_CASE("balls that are apart do not penetrate, though their boxes overlap") {
  const Measured balls({in_cage(ball_mesh({0, 0, 0}, 1, 12), 0.5), in_cage(ball_mesh({1.2, 1.2, 1.2}, 1, 12), 0.5)});
  check_nothing(balls.at_rest());
}

TEST_CASE("a ball inside another lies as deep as its innermost point, and crosses nothing") {
  const Measured balls({in_cage(ball_mesh({0, 0, 0}, 1, 24), 0.5), in_cage(ball_mesh({0.5, 0, 0}, 0.2, 8), 0.1)},
                       {.spacing = 100});
  const PenetrationReport report = balls.at_rest();
  CHECK(report.between.depth == Approx(0.7).epsilon(0.01));
  CHECK(report.between.body == 1);
  CHECK(report.points_inside == 6 * 9 * 9);
  CHECK(report.edges_crossing == 0);
}

TEST_CASE("only bodies that may touch are measured") {
  const std::vector<Caged> balls{in_cage(ball_mesh({0, 0, 0}, 1, 8), 0.5), in_cage(ball_mesh({1, 0, 0}, 1, 8), 0.5)};
  CHECK(Measured(balls).at_rest().between.depth > 0.8);
  check_nothing(Measured(balls, {}, {{.a = 0, .b = 1, .touch = false, .friction = {}}}).at_rest());
}

TEST_CASE("a mesh that is inside out as a whole is measured as if it were not") {
  TriangleMesh mesh = ball_mesh({0, 0, 0}, 1, 8);
  mesh.triangles.col(0).swap(mesh.triangles.col(1));
  const Measured balls({in_cage(mesh, 0.5), in_cage(ball_mesh({1.5, 0, 0}, 1, 8), 0.5)});
  CHECK(balls.at_rest().between.depth == Approx(0.5).epsilon(0.05));
}

TEST_CASE("bars that cross with no vertex in each other are seen by their edges, and by points on their faces") {
  const std::vector<Caged> bars{in_cage(box_mesh({-0.5, 0, -0.05}, {0.5, 0.1, 0.05}, {1, 1, 1}), 0.1),
                                in_cage(box_mesh({-0.05, 0.06, -0.5}, {0.05, 0.16, 0.5}, {1, 1, 1}), 0.1)};
  const PenetrationReport edges = Measured(bars, {.spacing = 100}).at_rest();
  CHECK(edges.points_inside == 0);
  CHECK(edges.edges_crossing >= 4);
  CHECK(edges.crossing.depth == Approx(0.04));
  const PenetrationReport points = Measured(bars).at_rest();
  CHECK(points.between.depth == Approx(0.04).epsilon(0.1));
}

TEST_CASE("a bar bent to a ring penetrates itself where its ends pass each other, by as much as they do") {
  const Measured bar = make_bar();
  check_nothing(bar.at_rest());
  check_nothing(bar.mapped([](const Vector3d& p) { return ring(p, 1.97 * pi); }));
  const double overlap = 0.05;  // [rad]
  const PenetrationReport report = bar.mapped([&](const Vector3d& p) { return ring(p, 2 * pi + overlap); });
  const double radius = 2 / (2 * pi + overlap) + 0.025;  // the outermost row of which the end is nearer than the side
  CHECK(report.within.depth == Approx(radius * std::sin(overlap)).epsilon(0.05));
  CHECK(report.within.cells == Approx(report.within.depth / 0.05));
  CHECK(report.crossing.depth > 0);
  CHECK(report.between.depth == 0);
}

TEST_CASE("a sharp fold is no penetration until the halves pass through each other") {
  const Measured bar = make_bar();
  check_nothing(bar.mapped([](const Vector3d& p) { return fold(p, 0.95 * pi); }));
  const PenetrationReport report = bar.mapped([](const Vector3d& p) { return fold(p, 1.02 * pi); });
  // the free ends pass each other, near which the bar is 0.1 thick
  CHECK(report.within.depth > 0.04);
  CHECK(report.within.depth < 0.07);
}

TEST_CASE("what overlaps itself at rest does not count, moved, turned and stretched") {
  const TriangleMesh around = box_mesh({0, 0, 0}, {1, 1, 1}, {20, 20, 20}),
                     inner = box_mesh({0.4, 0.4, 0.4}, {0.6, 0.6, 0.6}, {4, 4, 4}),
                     beside = box_mesh({0.32, 0.31, 0.33}, {1.3, 0.69, 0.67}, {1, 1, 1});
  const Measured body({in_cage(joined(joined(around, inner), beside), 0.1)});
  check_nothing(body.at_rest());
  const Matrix3d deformation = Random(4).rotation() * Vector3d(1.2, 0.9, 0.95).asDiagonal();
  check_nothing(body.mapped([&](const Vector3d& p) -> Vector3d { return deformation * p + Vector3d(3, 2, 1); }));
}

TEST_CASE("a coarse triangle is held against far parts where it has left its hexes") {
  // a ball above a plate of twelve triangles: both sag in the middle; its corners stay, and so does what they span
  const TriangleMesh plate = box_mesh({0, 0, 0}, {1, 1, 0.1}, {1, 1, 1}), ball = ball_mesh({0.5, 0.5, 0.35}, 0.08, 8);
  const Measured body({in_cage(joined(plate, ball), 0.1)});
  check_nothing(body.at_rest());
  const PenetrationReport report = body.mapped([](const Vector3d& p) -> Vector3d {
    return p - 0.3 * (1 - 2 * (p.head<2>().array() - 0.5).square().sum()) * Vector3d::UnitZ();
  });
  CHECK(report.within.depth == Approx(0.05).epsilon(0.1));
  CHECK(report.edges_crossing > 0);
}

TEST_CASE("hexes are close where one comes close to another that shares no node with it, and there alone") {
  const Measured bar = make_bar();
  const auto close_at = [&](double turn) {
    Points nodes = bar.model.rest_positions;
    for (auto node : nodes.rowwise()) node = ring(node.transpose(), turn).transpose();
    return close_hexes(bar.model, 0, hex_hulls(bar.model, 0, nodes), 0.01);
  };
  for (const std::vector<int>& none : close_at(1.5 * pi)) CHECK(none.empty());
  const std::vector<std::vector<int>> close = close_at(2 * pi);
  const int last = int(close.size()) - 1;
  CHECK(std::count(close.front().begin(), close.front().end(), last) == 0);  // across the bar from it
  CHECK(std::count(close.back().begin(), close.back().end(), 8) == 1);       // the bar's cells: 41 x 3 x 3
  CHECK(close[std::size_t(last) / 2].empty());
}

TEST_CASE("penetration is measured to the same bits with 1 and 2 threads") {
  const Measured balls({in_cage(ball_mesh({0, 0, 0}, 1, 30), 0.2), in_cage(ball_mesh({1.7, 0.1, 0}, 1, 30), 0.3),
                        in_cage(ball_mesh({0.8, 1.5, 0.2}, 1, 30), 0.2)});
  std::vector<PenetrationReport> reports;
  for (const std::size_t threads : {1, 2}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    reports.push_back(balls.at_rest());
  }
  const auto equal = [](const Penetration& a, const Penetration& b) {
    return a.depth == b.depth && a.body == b.body && a.other == b.other && a.place == b.place;
  };
  CHECK(reports[0].between.depth > 0.2);
  CHECK(equal(reports[0].between, reports[1].between));
  CHECK(equal(reports[0].crossing, reports[1].crossing));
  CHECK(reports[0].points_inside == reports[1].points_inside);
  CHECK(reports[0].edges_crossing == reports[1].edges_crossing);
}
