// Lengths x s, times x sqrt(s), Young's modulus x s, energy limits x s^4, Rayleigh alpha / sqrt(s), beta x sqrt(s);
// gravity, density, friction and Poisson's ratio as they are: the same motion at another size.
#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

struct Trial {
  SolverMethod method = SolverMethod::paper;
  bool contact = false;
  LimitUnit unit = LimitUnit::energy;
  int steps = 60;
};

double scaled_limit(LimitUnit unit, double s) {
  switch (unit) {
    case LimitUnit::energy:
      return 2 * s * s * s * s;
    case LimitUnit::density:
      return 250 * s;
    case LimitUnit::stretch:
      break;
  }
  return 0.06;
}

Body scaled_block(const Trial& trial, double s) {
  const double size = 0.2 * s;
  const Vector3d origin = s * Vector3d(1, trial.contact ? 0.5 : 5, 0);
  Body body = test::make_block({3, 2, 2}, origin, size);
  body.material = {.young = 1.5e5 * s, .poisson = 0.3, .density = 500, .mass = MassModel::lattice};
  body.material.damping_mass = 0.5 / std::sqrt(s);
  body.material.damping_stiffness = 0.002 * std::sqrt(s);
  body.limit = {.kind = LimitKind::hard, .unit = trial.unit, .value = scaled_limit(trial.unit, s)};
  body.velocity = std::sqrt(s) * Vector3d(1, -1, 0.5);
  body.spin = Vector3d(4, 3, -5) / std::sqrt(s);
  body.rest_distance = test::sample_distance(
      [&](const Vector3d& p) { return test::box_distance(p, origin, origin + size * Vector3d(3, 2, 2)); }, origin,
      origin + size * Vector3d(3, 2, 2), size / 4);
  return body;
}

std::vector<Obstacle> scaled_obstacles(const Trial& trial, double s) {
  if (!trial.contact) return {};
  Obstacle box{.name = "box", .shape = Block{s * Vector3d(0.2, 0.2, 0.7)}, .friction = 0.4};
  box.position = Track<Vector3d>(s * Vector3d(1.7, 0.1, 0.2));
  return {test::make_ground(0.4), box};
}

// the motion brought back to size 1
struct Motion {
  Points positions, velocities;
  int limited_steps = 0, contact_steps = 0;
};

Motion motion_at_scale(const Trial& trial, double s) {
  const Model model = make_model({scaled_block(trial, s)}, scaled_obstacles(trial, s));
  StepOptions options{.time_step = std::sqrt(s) / 60};
  options.solver.method = trial.method;
  options.solver.tolerance = 1e-2;
  State state = rest_state(model);
  state.positions.col(0) *= 1.15;  // beyond the limits, and back
  Motion motion;
  test::simulate(model, options, trial.steps, state, [&](const StepReport& report, const State&) {
    motion.limited_steps += report.limits_active > 0;
    motion.contact_steps += report.contacts > 0;
  });
  motion.positions = state.positions / s;
  motion.velocities = state.velocities / std::sqrt(s);
  return motion;
}

double difference(const Motion& a, const Motion& b) {
  return std::max((a.positions - b.positions).cwiseAbs().maxCoeff(),
                  (a.velocities - b.velocities).cwiseAbs().maxCoeff());
}

}  // namespace

TEST_CASE("a sixteenth and sixteen times the size move as the original") {
  Trial trial;
  trial.method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  trial.contact = GENERATE(false, true);
  trial.unit = GENERATE(LimitUnit::energy, LimitUnit::density, LimitUnit::stretch);
  CAPTURE(int(trial.method), trial.contact, int(trial.unit));
  const Motion original = motion_at_scale(trial, 1);
  CHECK(original.limited_steps > 0);
  if (trial.contact) CHECK(original.contact_steps > 5);
  for (const double s : {1.0 / 16, 16.0})
    CHECK(difference(motion_at_scale(trial, s), original) < (trial.contact ? 1e-6 : 1e-12));
}

TEST_CASE("a tenth and ten times the size move as the original for a second") {
  Trial trial;
  trial.method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  trial.contact = true;
  const Motion original = motion_at_scale(trial, 1);
  for (const double s : {0.1, 10.0}) CHECK(difference(motion_at_scale(trial, s), original) < 1e-4);
}
