#include "tools/reproduce/shape_motion.h"

#include <Eigen/Geometry>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

namespace {

/// A block that is deformed, turned and moved, at rest.
State deformed_state(const Model& model, Random& random) {
  State state = rest_state(model);
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) state.positions.row(i) += random.vector(0.03);
  state.positions = (state.positions * random.rotation().transpose()).rowwise() + random.vector(5).transpose();
  return state;
}

void set_velocities(State& state, const Matrix3d& L, const Vector3d& translation) {
  state.velocities = (state.positions * L.transpose()).rowwise() + translation.transpose();
}

double kinetic_energy(const Model& model, const Model::BodyRange& body, const State& state) {
  double energy = 0;
  for (int i = body.first_node; i < body.first_node + body.num_nodes; ++i)
    energy += 0.5 * model.node_mass[i] * state.velocities.row(i).squaredNorm();
  return energy;
}

/// Alternating along every axis: the fastest wave that a lattice carries.
void add_zigzag(State& state, int cells, double speed) {
  for (Eigen::Index i = 0; i < state.velocities.rows(); ++i) {
    const int n = int(i), k = n % (cells + 1), j = n / (cells + 1) % (cells + 1), l = n / (cells + 1) / (cells + 1);
    state.velocities(i, 1) += (j + k + l) % 2 ? speed : -speed;
  }
}

}  // namespace

TEST_CASE("spin and translation are rigid motion only") {
  Random random(1);
  const Model model = make_model({make_block({3, 2, 4}, {1, 2, 3}, 0.1)}, {});
  for (int i = 0; i < 5; ++i) {
    State state = deformed_state(model, random);
    const Vector3d spin = random.vector(3);
    Matrix3d L;
    L << 0, -spin[2], spin[1], spin[2], 0, -spin[0], -spin[1], spin[0], 0;
    set_velocities(state, L, random.vector(3));
    const ShapeMotion motion = shape_motion(model, model.bodies[0], state);
    CHECK(motion.rigid == Approx(kinetic_energy(model, model.bodies[0], state)).epsilon(1e-12));
    CHECK(motion.affine < 1e-24 * motion.rigid);
    CHECK(motion.waves < 1e-24 * motion.rigid);
  }
}

TEST_CASE("a uniform change of shape about the centre of mass is affine motion only") {
  Random random(2);
  const Model model = make_model({make_block({3, 2, 4}, {1, 2, 3}, 0.1)}, {});
  const State state = rest_state(model);
  const Vector3d centre = mean_of(model.node_mass, state.positions);
  for (const Matrix3d& L : {Matrix3d(Vector3d(1, -0.5, -0.5).asDiagonal()), Matrix3d(Matrix3d::Identity())}) {
    State squashed = state;
    set_velocities(squashed, L, -L * centre);
    const ShapeMotion motion = shape_motion(model, model.bodies[0], squashed);
    CHECK(motion.affine == Approx(kinetic_energy(model, model.bodies[0], squashed)).epsilon(1e-12));
    CHECK(motion.rigid + motion.waves < 1e-24 * motion.affine);
  }
  // any linear field has no waves; its turning part is rigid
  State linear = deformed_state(model, random);
  set_velocities(linear, random.matrix(1), random.vector(1));
  const ShapeMotion motion = shape_motion(model, model.bodies[0], linear);
  CHECK(motion.waves < 1e-24 * motion.total());
  CHECK(motion.rigid > 1e-6 * motion.total());
  CHECK(motion.affine > 1e-6 * motion.total());
}

TEST_CASE("what neither moves nor squashes a body is waves, whatever else the body does") {
  constexpr int cells = 5;  // odd: the zigzag has no mean
  const Model model = make_model({make_block({cells, cells, cells}, {0, 0, 0}, 0.1)}, {});
  State state = rest_state(model);
  add_zigzag(state, cells, 2);
  const ShapeMotion alone = shape_motion(model, model.bodies[0], state);
  CHECK(alone.waves == Approx(alone.total()).epsilon(1e-12));

  // rigid and affine motion on top leave the waves alone
  Random random(3);
  State both = state;
  set_velocities(both, random.matrix(1), random.vector(4));
  both.velocities += state.velocities;
  const ShapeMotion motion = shape_motion(model, model.bodies[0], both);
  CHECK(motion.waves == Approx(alone.waves).epsilon(1e-12));
  CHECK(motion.rigid > motion.waves);
}

TEST_CASE("rigid motion, affine motion and waves sum to the kinetic energy of their body") {
  Random random(4);
  Body held = make_block({2, 3, 2}, {0, 0, 0}, 0.2);
  held.fixed_nodes = {0, 1, 2, 3};
  const Model model =
      make_model({make_block({3, 2, 4}, {1, 2, 3}, 0.1), held, make_block({1, 1, 1}, {3, 0, 0}, 1)}, {});
  for (int i = 0; i < 5; ++i) {
    State state = deformed_state(model, random);
    for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
      if (!model.node_fixed[node]) state.velocities.row(node) = random.vector(2);
    for (const Model::BodyRange& body : model.bodies) {
      const ShapeMotion motion = shape_motion(model, body, state);
      CHECK(motion.total() == Approx(kinetic_energy(model, body, state)).epsilon(1e-12));
      CHECK(motion.rigid > 0);
      CHECK(motion.affine > 0);
      CHECK(motion.waves > 0);
    }
  }
}

TEST_CASE("a body flattened to a plane, a line or a point loses affine motions but no energy") {
  Random random(5);
  const Model model = make_model({make_block({2, 2, 2}, {1, 1, 1}, 0.1)}, {});
  const Matrix3d turn = random.rotation();
  for (const Vector3d& stretch : {Vector3d(1, 1, 0), Vector3d(1, 0, 0), Vector3d(0, 0, 0), Vector3d(1, 1, 1e-9)}) {
    State state = rest_state(model);
    state.positions = state.positions * stretch.asDiagonal() * turn.transpose();
    for (Eigen::Index node = 0; node < model.num_nodes(); ++node) state.velocities.row(node) = random.vector(2);
    const ShapeMotion motion = shape_motion(model, model.bodies[0], state);
    CHECK(motion.total() == Approx(kinetic_energy(model, model.bodies[0], state)).epsilon(1e-12));

    // a spin is rigid still
    set_velocities(state,
                   Matrix3d(turn * Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()) * turn.transpose() -
                            turn * Vector3d::UnitX() * Vector3d::UnitX().transpose() * turn.transpose()),
                   {1, 2, 3});
    const ShapeMotion spun = shape_motion(model, model.bodies[0], state);
    CHECK(spun.rigid == Approx(spun.total()).epsilon(1e-12));
  }
  State resting = rest_state(model);
  CHECK(shape_motion(model, model.bodies[0], resting).total() == 0);
}
