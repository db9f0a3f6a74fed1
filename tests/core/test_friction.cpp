// Coulomb's law seen from outside: blocks on inclines and on moving plates.
#include <numbers>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

constexpr double gravity = 9.81;

struct Incline {
  SolverMethod method = SolverMethod::paper;
  double degrees = 0;
  double friction = 0;
};

double slope_of(const Incline& incline) {
  return std::tan(incline.degrees * std::numbers::pi / 180);
}

// the block lies on the tilted plane; y' is its normal, x' points downhill
struct Slide {
  Model model;
  Vector3d downhill;
  StepOptions options;
};

Slide make_slide(const Incline& incline) {
  const Matrix3d tilt = rotation_from_degrees({0, 0, -incline.degrees});
  Body block = test::make_block({4, 2, 4}, {0, 0, 0}, 0.1, 1);
  block.material.young = 5e6;
  block.material.damping_stiffness = 0.002;
  block.friction = 0;
  Obstacle plane = test::make_ground(incline.friction);
  plane.rotation_degrees = Track<Vector3d>(Vector3d(0, 0, -incline.degrees));
  Slide slide{
      .model = make_model({test::turned(block, tilt)}, {plane}), .downhill = tilt * Vector3d::UnitX(), .options = {}};
  slide.options.time_step = 0.01;
  slide.options.solver.method = incline.method;
  slide.options.solver.sweep_tolerance = 1e-8;
  return slide;
}

// along the slope, of the centre of mass
struct Path {
  std::vector<double> position, velocity;
};

Path slide_down(const Incline& incline, int steps) {
  const Slide slide = make_slide(incline);
  State state = rest_state(slide.model);
  Path path;
  test::simulate(slide.model, slide.options, steps, state, [&](const StepReport&, const State& now) {
    path.position.push_back(slide.downhill.dot(test::mean_of(slide.model.node_mass, now.positions)));
    path.velocity.push_back(slide.downhill.dot(test::mean_of(slide.model.node_mass, now.velocities)));
  });
  return path;
}

}  // namespace

TEST_CASE("a block on an incline sticks without creep when tan(theta) <= mu") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const double degrees = GENERATE(5.0, 20.0, 35.0);
  Incline incline{method, degrees, 0};
  incline.friction = GENERATE_COPY(1.02 * slope_of(incline), 2 * slope_of(incline));
  CAPTURE(int(method), degrees, incline.friction);
  const Path path = slide_down(incline, 150);
  // after half a second to settle: a micrometre a second at most on a block of 40 cm
  CHECK(std::abs(path.position[149] - path.position[49]) < 1e-6);
}

TEST_CASE("a block on an incline slides with g (sin - mu cos) when tan(theta) > mu") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const double degrees = GENERATE(10.0, 25.0, 40.0);
  Incline incline{method, degrees, 0};
  incline.friction = GENERATE_COPY(0.0, 0.3 * slope_of(incline), 0.8 * slope_of(incline));
  CAPTURE(int(method), degrees, incline.friction);
  const Path path = slide_down(incline, 100);
  const double theta = degrees * std::numbers::pi / 180;
  const double expected = gravity * (std::sin(theta) - incline.friction * std::cos(theta));
  CHECK((path.velocity[99] - path.velocity[29]) / 0.7 == Approx(expected).epsilon(0.02));
}

TEST_CASE("the larger coefficient of a pair counts") {
  Incline incline{SolverMethod::paper, 20, 0};
  const Slide bare = make_slide(incline);
  Slide rough = bare;
  rough.model.bodies[0].friction = 1;
  const State slid = test::simulate(bare.model, bare.options, 50),
              stuck = test::simulate(rough.model, rough.options, 50);
  CHECK(test::momentum(bare.model, slid).norm() > 1);
  CHECK(test::momentum(rough.model, stuck).norm() < 1e-2);
}

TEST_CASE("a moving plate carries a resting block by friction, as fast as friction can") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  // the plate reaches 1 m/s at once: the block follows with mu g, then rides along
  Body block = test::make_block({3, 2, 3}, {0, 0, 0}, 0.1, 1);
  block.material.young = 5e6;
  block.material.damping_stiffness = 0.002;
  Obstacle plate = {.name = "plate", .shape = Block{{5, 0.5, 5}}, .friction = 0.5};
  plate.position.times = {0, 10};
  plate.position.values = {Vector3d(0, -0.5, 0), Vector3d(10, -0.5, 0)};
  block.friction = 0;
  const Model model = make_model({block}, {plate});
  StepOptions options{.time_step = 0.01};
  options.solver.method = method;
  State state = rest_state(model);
  std::vector<double> speed;
  test::simulate(model, options, 60, state, [&](const StepReport&, const State& now) {
    speed.push_back(test::mean_of(model.node_mass, now.velocities).x());
  });
  CHECK((speed[14] - speed[4]) / 0.1 == Approx(0.5 * gravity).epsilon(0.05));
  CHECK(speed[59] == Approx(1).margin(1e-3));
}

TEST_CASE("a turning plate carries a block around") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  Body block = test::make_block({2, 2, 2}, {0.3, 0, -0.1}, 0.1, 1);
  block.material.young = 5e6;
  block.material.damping_stiffness = 0.002;
  Obstacle plate = {.name = "plate", .shape = Block{{5, 0.5, 5}}, .friction = 0.8};
  plate.position = Track<Vector3d>(Vector3d(0, -0.5, 0));
  plate.rotation_degrees.times = {0, 1};
  plate.rotation_degrees.values = {Vector3d(0, 0, 0), Vector3d(0, 90, 0)};
  plate.rotation_degrees.interpolation = Interpolation::smooth;
  const Model model = make_model({block}, {plate});
  StepOptions options{.time_step = 0.01};
  options.solver.method = method;
  const State state = test::simulate(model, options, 110);
  const Vector3d centre = test::mean_of(model.node_mass, state.positions);
  // a quarter turn about Y takes (0.4, y, 0) to (0, y, -0.4)
  CHECK((centre - Vector3d(0, centre.y(), -0.4)).norm() < 0.01);
}
