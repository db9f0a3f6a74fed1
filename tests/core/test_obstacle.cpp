#include "core/model/obstacle.h"

#include <limits>

#include "core/element/rotation.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using test::Random;

namespace {

ObstacleShape sampled_ball(double radius) {
  const auto distance = [radius](const Vector3d& p) { return p.norm() - radius; };
  return MeshShape{test::sample_distance(distance, Vector3d::Constant(-radius), Vector3d::Constant(radius), 0.05), {}};
}

// closest point on the box's surface by trying a fine grid of its faces
double brute_force_box_distance(const Vector3d& half, const Vector3d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  constexpr int n = 200;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
          Vector3d q;
          q[axis] = side * half[axis];
          q[(axis + 1) % 3] = half[(axis + 1) % 3] * (2.0 * i / n - 1);
          q[(axis + 2) % 3] = half[(axis + 2) % 3] * (2.0 * j / n - 1);
          nearest = std::min(nearest, (p - q).norm());
        }
  return (p.cwiseAbs().array() < half.array()).all() ? -nearest : nearest;
}

}  // namespace

TEST_CASE("distances to the plane and the ball are those of the closed form") {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d p = random.vector(3);
    CHECK(signed_distance(HalfSpace{}, p).distance == p.y());
    CHECK(signed_distance(Ball{1.5}, p).distance == Approx(p.norm() - 1.5));
    CHECK((signed_distance(Ball{1.5}, p).gradient - p.normalized()).norm() < 1e-14);
  }
}

TEST_CASE("the distance to a box is that of the closest surface point, negative inside") {
  Random random(2);
  const Vector3d half(1, 0.5, 0.7);
  for (int i = 0; i < 20; ++i) {
    const Vector3d p = random.vector(1.5);
    CHECK(signed_distance(Block{half}, p).distance == Approx(brute_force_box_distance(half, p)).margin(0.01));
  }
}

TEST_CASE("the gradient is the unit direction in which the distance grows") {
  Random random(3);
  const std::vector<ObstacleShape> shapes{HalfSpace{}, Ball{1}, Block{{1, 0.5, 0.7}}, sampled_ball(1)};
  for (const ObstacleShape& shape : shapes)
    for (int i = 0; i < 30; ++i) {
      const Vector3d p = random.vector(1.4);
      const DistanceSample sample = signed_distance(shape, p);
      CHECK(sample.gradient.norm() == Approx(1));
      const double h = 1e-6;
      const double rise = signed_distance(shape, p + h * sample.gradient).distance -
                          signed_distance(shape, p - h * sample.gradient).distance;
      CHECK(rise / (2 * h) == Approx(1).margin(0.02));  // a trilinear distance grows at nearly unit rate
    }
}

TEST_CASE("points on a medial axis still have a finite unit direction") {
  for (const ObstacleShape& shape : {ObstacleShape(Ball{1}), ObstacleShape(Block{{1, 1, 1}}), sampled_ball(1)}) {
    const DistanceSample sample = signed_distance(shape, Vector3d::Zero());
    CHECK(sample.distance < -0.9);
    CHECK(sample.gradient.norm() == Approx(1));
  }
}

TEST_CASE("a sampled distance reproduces linear fields exactly and continues beyond its grid") {
  const Vector3d slope = Vector3d(1, 2, 2) / 3;
  const auto grid = test::sample_distance([&](const Vector3d& p) { return slope.dot(p) - 0.125; }, Vector3d::Zero(),
                                          Vector3d::Ones(), 0.25);
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const Vector3d p = Vector3d::Constant(0.5) + random.vector(0.5);
    CHECK(signed_distance(*grid, p).distance == Approx(slope.dot(p) - 0.125).margin(1e-6));
    CHECK((signed_distance(*grid, p).gradient - slope).norm() < 1e-5);
  }
  const double inside = signed_distance(*grid, Vector3d(0.5, 0.5, 1.5)).distance;
  CHECK(signed_distance(*grid, Vector3d(0.5, 0.5, 1.5 + 7)).distance == Approx(inside + 7));
}

TEST_CASE("a sampled ball is as far away as the ball, inside and outside its grid") {
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    const Vector3d direction = random.vector(1).normalized();
    CHECK(signed_distance(sampled_ball(1), 0.9 * direction).distance == Approx(-0.1).margin(1e-3));
    // the distance to the grid's box plus the edge value never overestimates by more than the box's slack
    CHECK(signed_distance(sampled_ball(1), 5 * direction).distance > 2.5);
  }
}

TEST_CASE("a pose turns about X, then Y, then Z, and back") {
  Obstacle obstacle;
  obstacle.position = Track<Vector3d>(Vector3d(1, 2, 3));
  obstacle.rotation_degrees = Track<Vector3d>(Vector3d(90, 0, 90));
  const Pose pose = pose_at(obstacle, 0);
  CHECK((pose.world({0, 1, 0}) - Vector3d(1, 2, 4)).norm() < 1e-14);  // y -> z, and z stays under Z
  CHECK((pose.world({1, 0, 0}) - Vector3d(1, 3, 3)).norm() < 1e-14);  // x stays, then -> y
  Random random(6);
  const Vector3d p = random.vector(2);
  CHECK((pose.local(pose.world(p)) - p).norm() < 1e-14);
}

TEST_CASE("a keyframed obstacle follows its tracks") {
  Obstacle obstacle;
  obstacle.position.times = {0, 2};
  obstacle.position.values = {Vector3d(0, 0, 0), Vector3d(4, 0, 0)};
  CHECK(pose_at(obstacle, 0.5).translation == Vector3d(1, 0, 0));
  CHECK(pose_at(obstacle, 9).translation == Vector3d(4, 0, 0));
}

TEST_CASE("the top of an obstacle under a footprint is found") {
  const Vector3d low(-0.1, 0, -0.1), high(0.1, 1, 0.1);
  Obstacle obstacle;
  obstacle.position = Track<Vector3d>(Vector3d(0, 0.5, 0));
  obstacle.shape = HalfSpace{};
  CHECK(highest_point_below(obstacle, 0, low, high) == Approx(0.5));
  obstacle.shape = Ball{2};
  CHECK(highest_point_below(obstacle, 0, low, high) == Approx(2.5).margin(1e-5));
  obstacle.shape = Block{{1, 0.25, 1}};
  CHECK(highest_point_below(obstacle, 0, low, high) == Approx(0.75).margin(1e-5));
  CHECK(highest_point_below(obstacle, 0, low + Vector3d(5, 0, 0), high + Vector3d(5, 0, 0)) < -1e9);
  obstacle.shape = HalfSpace{};
  obstacle.rotation_degrees = Track<Vector3d>(Vector3d(0, 0, 45));
  CHECK(highest_point_below(obstacle, 0, low, high) == Approx(0.6));  // the slope's upper end of the footprint
}
