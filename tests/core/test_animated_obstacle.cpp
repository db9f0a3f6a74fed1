// Obstacles whose vertices are animated push, drag and stop bodies as their surface moves.
#include "core/contact/moving_obstacle.h"
#include "core/model/deformation.h"
#include "core/model/rest_surface.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

namespace {

// corners of the box, and its twelve triangles, counter-clockwise from outside
struct BoxMesh {
  Points corners{8, 3};
  Triangles triangles{12, 3};
};
BoxMesh box_mesh(const Vector3d& low, const Vector3d& high) {
  BoxMesh box;
  for (int i = 0; i < 8; ++i)
    box.corners.row(i) << (i & 4 ? high : low).x(), (i & 2 ? high : low).y(), (i & 1 ? high : low).z();
  box.triangles << 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1,
      7, 3;
  return box;
}

MeshMotion motion_of(const std::vector<double>& times, const std::vector<Points>& samples) {
  MeshMotion motion;
  motion.times = times;
  motion.num_vertices = samples.front().rows();
  for (const Points& sample : samples)
    for (const double value : sample.reshaped<Eigen::RowMajor>()) motion.samples.push_back(float(value));
  return motion;
}

Obstacle animated(const Points& rest, const Triangles& triangles, MeshMotion motion, double thickness = 0,
                  bool is_closed = true) {
  TriangleShape shape;
  shape.surface = std::make_shared<const RestSurface>(make_rest_surface(rest, triangles));
  shape.thickness = thickness;
  shape.is_closed = is_closed;
  Obstacle obstacle{.name = "animated", .shape = shape};
  obstacle.deformation = std::make_shared<const Deformation>(std::move(motion), shape);
  return obstacle;
}

Points moved(const Points& points, const Vector3d& by) {
  return points.rowwise() + by.transpose();
}

// a floor 4 m wide and 1 m thick, whose top moves from one place to others
Obstacle moving_floor(const std::vector<double>& times, const std::vector<Vector3d>& places, double friction) {
  const BoxMesh box = box_mesh({-2, -1, -2}, {2, 0, 2});
  std::vector<Points> samples;
  for (const Vector3d& place : places) samples.push_back(moved(box.corners, place));
  Obstacle floor = animated(box.corners, box.triangles, motion_of(times, samples));
  floor.friction = friction;
  return floor;
}

}  // namespace

TEST_CASE("an animated mesh is linear between its samples and stands still outside of them") {
  const BoxMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  MeshMotion motion = motion_of({1, 2, 4}, {box.corners, moved(box.corners, {0, 1, 0}), moved(box.corners, {2, 1, 0})});
  motion.placed_from_own = Eigen::Affine3d(Eigen::Scaling(2.0));
  const auto place = [&](double time) { return Vector3d(positions_at(motion, time).row(0).transpose()); };
  CHECK(place(-5) == Vector3d(0, 0, 0));
  CHECK(place(1) == Vector3d(0, 0, 0));
  CHECK((place(1.25) - Vector3d(0, 0.5, 0)).norm() < 1e-12);
  CHECK((place(3) - Vector3d(2, 2, 0)).norm() < 1e-12);
  CHECK(place(4) == Vector3d(4, 2, 0));
  CHECK(place(9) == Vector3d(4, 2, 0));
  CHECK(largest_speed(motion) == Approx(2));
}

TEST_CASE("moved triangles have the distances of a surface made anew") {
  const BoxMesh box = box_mesh({-1, -1, -1}, {1, 1, 1});
  const RestSurface rest = make_rest_surface(box.corners, box.triangles);
  Random random(3);
  Points sheared = box.corners;
  for (int i = 0; i < 8; ++i) sheared.row(i) += random.vector(0.3).transpose();
  const RestSurface moved = moved_surface(rest, sheared), anew = make_rest_surface(sheared, box.triangles);
  for (int i = 0; i < 500; ++i) {
    const Vector3d p = random.vector(2);
    const SurfaceHit a = nearest_point(moved, p, 10), b = nearest_point(anew, p, 10);
    CHECK(a.distance == b.distance);
    CHECK(a.normal == b.normal);
  }
}

TEST_CASE("triangles tell inside from outside, and open ones push from both of their sides") {
  const BoxMesh box = box_mesh({-1, -1, -1}, {1, 1, 1});
  TriangleShape closed;
  closed.surface = std::make_shared<const RestSurface>(make_rest_surface(box.corners, box.triangles));
  CHECK(signed_distance(ObstacleShape(closed), Vector3d(0, 0.7, 0)).distance == Approx(-0.3));
  CHECK(signed_distance(ObstacleShape(closed), Vector3d(0, 1.5, 0)).distance == Approx(0.5));
  TriangleShape sheet;
  sheet.surface = std::make_shared<const RestSurface>(make_rest_surface(box.corners, box.triangles.topRows(2)));
  sheet.is_closed = false;
  sheet.thickness = 0.2;
  for (const double side : {-1.0, 1.0}) {  // of the plane x = -1
    const DistanceSample outside = signed_distance(ObstacleShape(sheet), Vector3d(-1 + side * 0.5, 0.1, 0)),
                         inside = signed_distance(ObstacleShape(sheet), Vector3d(-1 + side * 0.03, 0.1, 0));
    CHECK(outside.distance == Approx(0.4));
    CHECK(outside.gradient.x() == Approx(side));
    CHECK(inside.distance == Approx(-0.07));
    CHECK(inside.gradient.x() == Approx(side));
  }
}

TEST_CASE("what an animated mesh does as a rigid motion is what keyframes do") {
  const double friction = GENERATE(0.0, 0.4);
  const std::vector<double> times{0, 0.1, 0.4, 0.6};
  const std::vector<Vector3d> places{{0, 0, 0}, {0, 0, 0}, {0.3, 0.15, 0}, {0.5, 0.05, 0.1}};
  Obstacle keyed{.name = "keyed", .shape = Block{{2, 0.5, 2}}, .friction = friction};
  keyed.position.times = times;
  for (const Vector3d& place : places) keyed.position.values.push_back(place - Vector3d(0, 0.5, 0));
  keyed.position.values.erase(keyed.position.values.begin());
  Body block = make_block({2, 2, 2}, {-0.1, 0.001, -0.1}, 0.1, 3);
  block.friction = 0;
  const auto end = [&](const Obstacle& obstacle) {
    const Model model = make_model({block}, {obstacle});
    State state = rest_state(model);
    simulate(model, StepOptions(), 40, state, [](const StepReport& report, const State&) {
      CHECK(report.status == StepStatus::converged);
      CHECK(report.max_penetration <= 1.1e-4);
    });
    return state;
  };
  const State a = end(keyed), b = end(moving_floor(times, places, friction));
  CHECK((a.positions - b.positions).cwiseAbs().maxCoeff() < 2e-4);  // samples are floats, tops are triangles
  CHECK((a.positions - rest_state(make_model({block}, {})).positions).cwiseAbs().maxCoeff() > 0.03);
}

TEST_CASE("a belt whose surface runs drags a block along up to its speed, at no more than friction allows") {
  // the top runs in x at 1 m/s; friction 0.3: the block gains 0.3 g until it has that speed, after 0.34 s
  constexpr double speed = 1, mu = 0.3, g = 9.81;
  Body block = make_block({1, 1, 1}, {-0.05, 0, -0.05}, 0.1, 3);
  block.material.young = 5e6;
  block.friction = 0;
  const Model model = make_model({block}, {moving_floor({0, 1}, {{0, 0, 0}, {speed, 0, 0}}, mu)});
  State state = rest_state(model);
  StepOptions options;
  options.time_step = 1.0 / 240;
  simulate(model, options, 120, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    const double velocity = mean_of(model.node_mass, now.velocities).x();
    CHECK(velocity == Approx(std::min(speed, mu * g * now.time)).margin(0.03));
  });
}

TEST_CASE("a surface that swells pushes a body by its own deformation") {
  // the top of the box rises in its middle alone: a bump below the block
  constexpr int n = 9;
  const auto top = [&](double height) {
    Points grid(n * n, 3);
    for (int i = 0; i < n * n; ++i) {
      const double x = (i / n - 4) * 0.1, z = (i % n - 4) * 0.1;
      grid.row(i) << x, height * std::exp(-(x * x + z * z) / 0.04), z;
    }
    return grid;
  };
  Triangles triangles(2 * (n - 1) * (n - 1), 3);
  for (int i = 0, t = 0; i < n - 1; ++i)
    for (int j = 0; j < n - 1; ++j) {
      const int a = i * n + j;
      triangles.row(t++) << a, a + 1, a + n + 1;
      triangles.row(t++) << a, a + n + 1, a + n;
    }
  Body block = make_block({2, 2, 2}, {-0.1, 0.011, -0.1}, 0.1, 4);
  Obstacle sheet = animated(top(0), triangles, motion_of({0, 0.3}, {top(0), top(0.2)}), 0.02, false);
  sheet.friction = 0.5;
  const Model model = make_model({block}, {sheet});
  State state = rest_state(model);
  simulate(model, StepOptions(), 30, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_penetration <= 1.1e-4);
  });
  CHECK(mean_of(model.node_mass, state.positions).y() > 0.11 + 0.15);
}

TEST_CASE("an obstacle that is faster than a cell a step is followed in several, and nothing comes through it") {
  const bool is_closed = GENERATE(true, false);
  const double speed = GENERATE(3, 15);  // [m/s] 0.5 and 2.5 cells a step
  CAPTURE(is_closed, speed);
  // a plate 3 cm thick, or a sheet of that thickness, that flies at a block
  const BoxMesh box = box_mesh({-1, -1, -0.015}, {1, 1, 0.015});
  Triangles sheet(2, 3);
  sheet << 0, 2, 6, 0, 6, 4;
  Points flat = box.corners;
  flat.col(2).setZero();
  const Points& rest = is_closed ? box.corners : flat;
  const Obstacle plate =
      animated(rest, is_closed ? box.triangles : sheet,
               motion_of({0, 0.2}, {moved(rest, {0, 0, -0.5}), moved(rest, {0, 0, -0.5 + 0.2 * speed})}),
               is_closed ? 0 : 0.03, is_closed);
  Body block = make_block({2, 2, 2}, {-0.1, -0.1, -0.1}, 0.1, 4);
  block.material.young = 1e6;
  const Model model = make_model({block}, {plate});
  StepOptions options;
  options.gravity.setZero();
  State state = rest_state(model);
  int most = 1;
  simulate(model, options, 12, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_penetration <= 1.1e-4);
    most = std::max(most, report.substeps);
    CHECK(now.positions.col(2).minCoeff() > -0.5 + speed * std::min(now.time, 0.2));
  });
  CHECK((most > 1) == (speed > 6));
  CHECK(most <= 8);
}

TEST_CASE("steps with an animated obstacle are the same bytes whatever was asked for before") {
  const Obstacle floor = moving_floor({0, 0.5}, {{0, 0, 0}, {0.2, 0.1, 0}}, 0.3);
  const Model model = make_model({make_block({2, 2, 2}, {-0.1, 0.05, -0.1}, 0.1, 3)}, {floor});
  State state = rest_state(model), again = state;
  simulate(model, StepOptions(), 20, state, [](const StepReport&, const State&) {});
  for (int i = 0; i < 20; ++i) {  // a new workspace each, and other instants in between
    for (const double time : {0.4, 0.0, 0.13}) obstacle_at(model.obstacles[0], time);
    Workspace workspace(model);
    step(model, StepOptions(), workspace, again);
  }
  CHECK(state.positions == again.positions);
  CHECK(state.velocities == again.velocities);
}
