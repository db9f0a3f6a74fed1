// Obstacles thinner than what bodies move in a step let nothing through.
#include "core/contact/obstacle_side.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double slack = 1e-3;

// a plate of this thickness [m] in the plane y = 0
ObstacleShape plate(double thickness, bool is_mesh) {
  const Vector3d half(1.5, 0.5 * thickness, 1.5);
  if (!is_mesh) return Block{half};
  return MeshShape{
      sample_distance([&](const Vector3d& p) { return box_distance(p, -half, half); }, -half, half, 0.3 * thickness),
      {}};
}

}  // namespace

TEST_CASE("a point that has come through a wall, or most of it, is measured from the side that it came by") {
  const ObstacleShape wall = plate(0.06, GENERATE(false, true));
  const Vector3d above(0.1, 0.5, 0.2);
  for (const double y : {0.02, -0.02, -0.1, -1.0}) {
    const DistanceSample sample = distance_from_side(wall, above, {0.3, y, -0.1}, slack);
    CHECK(sample.distance == Approx(y - 0.03).margin(1e-4));
    CHECK(sample.gradient.y() == Approx(1).margin(1e-6));
  }
  // likewise from below
  CHECK(distance_from_side(wall, {0, -0.5, 0}, {0, 0.7, 0}, slack).distance == Approx(-0.73).margin(1e-4));
  // one that rests on it, a little inside, and is pushed through
  CHECK(distance_from_side(wall, {0, 0.0295, 0}, {0, -0.04, 0}, slack).distance == Approx(-0.07).margin(1e-3));
}

TEST_CASE("a point that has come through nothing is measured by its nearest side") {
  const ObstacleShape shape = GENERATE(ObstacleShape(Block{{0.3, 0.05, 0.4}}), ObstacleShape(Ball{0.3}),
                                       ObstacleShape(HalfSpace{}), plate(0.06, true));
  Random random(7);
  int outside = 0, inside = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d X0 = random.vector(0.6), X = X0 + random.vector(0.2);
    double least = 1;  // along the way
    for (int k = 0; k <= 400; ++k) least = std::min(least, signed_distance(shape, X0 + k / 400.0 * (X - X0)).distance);
    const DistanceSample sample = distance_from_side(shape, X0, X, slack), nearest = signed_distance(shape, X);
    const bool was_inside = signed_distance(shape, X0).distance < -slack;
    if (least > slack || was_inside) {
      CHECK(sample.distance == nearest.distance);
      CHECK(sample.gradient == nearest.gradient);
      (was_inside ? inside : outside)++;
    } else {
      // never less deep than what is nearest, nor from a side that faces the other way
      CHECK(sample.distance <= nearest.distance);
    }
  }
  CHECK(outside > 100);
  CHECK((inside > 20 || std::holds_alternative<MeshShape>(shape)));
}

TEST_CASE("a body does not fall through a thin obstacle, however fast") {
  const bool is_mesh = GENERATE(false, true);
  const double speed = GENERATE(4, 12, 40);  // [m/s] 0.7 to 7 cells a step
  CAPTURE(is_mesh, speed);
  Body block = make_block({2, 2, 2}, {-0.1, 0.37, -0.1}, 0.1, 4);
  block.material.young = 1e6;
  block.velocity = {0, -speed, 0};
  Obstacle thin{.name = "thin", .shape = plate(0.04, is_mesh)};
  const Model model = make_model({block}, {thin});
  State state = rest_state(model);
  double fastest = 0;
  simulate(model, StepOptions(), 30, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_penetration <= 1.1e-4);
    CHECK(now.positions.col(1).minCoeff() > 0.01);
    fastest = std::max(fastest, report.kinetic_energy);
  });
  CHECK(fastest < 0.5 * total_mass(model) * (speed * speed + 2 * 9.81 * 0.4));  // no more than the fall gives
}

TEST_CASE("a thin obstacle that sweeps through the room takes what is in its way along") {
  const bool is_mesh = GENERATE(false, true);
  CAPTURE(is_mesh);
  Body block = make_block({2, 2, 2}, {-0.1, -0.1, 0.35}, 0.1, 4);
  block.material.young = 1e6;
  Obstacle blade{.name = "blade", .shape = plate(0.03, is_mesh)};
  blade.rotation_degrees = Vector3d(90, 0, 0);  // its faces look along z
  blade.position.times = {0, 0.2};
  blade.position.values = {Vector3d(0, 0, 0), Vector3d(0, 0, 2)};  // 17 cm a step
  const Model model = make_model({block}, {blade});
  StepOptions options = without_gravity();
  State state = rest_state(model);
  simulate(model, options, 12, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_penetration <= 1.1e-4);
    CHECK(now.positions.col(2).minCoeff() > pose_at(blade, now.time).translation.z());
  });
  CHECK(state.positions.col(2).minCoeff() > 1.9);
}
