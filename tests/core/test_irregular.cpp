// Irregular lattices in the program's own step: patch test, mass, the beam, limits; and factors per hex.
#include <Eigen/Geometry>
#include <string>

#include "core/base/error.h"
#include "core/problem/evaluation.h"
#include "tests/support/begun_step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/distorted.h"

using namespace umax;
using namespace umax::test;

namespace {

Body irregular_block(double share) {
  Body body = make_block({3, 3, 3}, {0.1, -0.2, 0.3}, 0.4);
  body.lattice = distorted_lattice(body.lattice, share);
  body.surface = {};
  body.surface.weights.resize(0, 8);
  body.surface_rest.resize(0, 3);
  return body;
}

bool is_inner(const Body& body, Eigen::Index node) {
  const Vector3d low = body.lattice.rest_positions.colwise().minCoeff(),
                 high = body.lattice.rest_positions.colwise().maxCoeff();
  const Vector3d x = body.lattice.rest_positions.row(node);
  return (x - low).minCoeff() > 1e-9 && (high - x).minCoeff() > 1e-9;
}

Evaluation evaluate_at(const Model& model, const Points& positions) {
  Evaluation evaluation;
  evaluate(test::BegunStep(model).problem, positions, evaluation);
  return evaluation;
}

Body distorted_beam(double share) {
  Body beam = make_beam();
  if (share > 0) beam.lattice = distorted_lattice(beam.lattice, share);
  return beam;
}

struct Swing {
  double lowest = 0, settled = 0;  // [m] height of the tip against its rest, least and last
  double max_ratio = 0;            // [-] largest U/U_max after any step
  bool all_converged = true;
};

// the mean height of the nine nodes of the free end, against their rest
Swing swing(const Body& beam, int steps) {
  const Model model = make_model({beam}, {});
  const StepOptions options{.time_step = 0.01};
  State state = rest_state(model);
  Swing result;
  const auto tip = [&](const Points& positions) {
    return positions.col(1).tail(9).mean() - model.rest_positions.col(1).tail(9).mean();
  };
  simulate(model, options, steps, state, [&](const StepReport& report, const State& now) {
    result.lowest = std::min(result.lowest, tip(now.positions));
    result.settled = tip(now.positions);
    result.max_ratio = std::max(result.max_ratio, report.max_energy_ratio);
    result.all_converged &= report.status == StepStatus::converged;
  });
  return result;
}

}  // namespace

TEST_CASE("finite patch test: an affine deformation of irregular hexes strains all alike and loads no inner node") {
  const Body body = irregular_block(0.3);
  const Model model = make_model({body}, {});
  REQUIRE(model.shapes.size() == 27);
  Matrix3d stretch;  // of several per cent, with shear, and then turned by an arbitrary rotation
  stretch << 1.04, 0.02, -0.03, 0.02, 0.94, 0.01, -0.03, 0.01, 1.02;
  const Matrix3d A = Random(3).rotation() * stretch;
  const Points positions = (model.rest_positions * A.transpose()).rowwise() + Eigen::RowVector3d(3, -2, 1);
  const Evaluation evaluation = evaluate_at(model, positions);

  const VectorXd force = gather(model, evaluation.elastic);
  double inner = 0;
  int num_inner = 0;
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    if (is_inner(body, node)) inner = std::max(inner, force.segment<3>(3 * node).cwiseAbs().maxCoeff()), ++num_inner;
  REQUIRE(num_inner == 8);
  CHECK(inner < 1e-12 * evaluation.elastic.cwiseAbs().maxCoeff());

  const double density = evaluation.elastic_energy[0] / model.shapes[0].volume;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    CHECK(evaluation.elastic_energy[e] / model.shapes[e].volume == Approx(density).epsilon(1e-12));
}

TEST_CASE("an irregular body that only turns and moves has no elastic energy and no force") {
  const Model model = make_model({irregular_block(0.3)}, {});
  const Points positions =
      (model.rest_positions * Random(4).rotation().transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
  const Evaluation evaluation = evaluate_at(model, positions);
  CHECK(evaluation.elastic_energy.cwiseAbs().maxCoeff() < 1e-20);  // [J]; 1 % of strain would store 1.6 J a hex
  CHECK(evaluation.elastic.cwiseAbs().maxCoeff() < 1e-8);          // [N]
}

TEST_CASE("an irregular body weighs density times volume, with the centre of mass of the solid it fills") {
  Body body = irregular_block(0.3);
  body.material.density = 700;
  const Model model = make_model({body}, {});
  CHECK(model.node_mass.sum() == Approx(700 * 1.2 * 1.2 * 1.2).epsilon(1e-13));
  CHECK(model.node_mass.minCoeff() > 0);
  const Vector3d centre = mean_of(model.node_mass, model.rest_positions);
  CHECK((centre - Vector3d(0.7, 0.4, 0.9)).norm() < 1e-13);  // equal shares of each hex would miss it by millimetres

  VectorXd equal = VectorXd::Zero(model.num_nodes());
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    for (int n = 0; n < 8; ++n) equal[model.hexes(e, n)] += 700 * model.shapes[e].volume / 8;
  CHECK((mean_of(equal, model.rest_positions) - Vector3d(0.7, 0.4, 0.9)).norm() > 1e-4);
}

TEST_CASE("a parallelepiped gives its nodes equal shares of its volume") {
  Matrix3d A;
  A << 1, 0.3, -0.2, 0.1, 0.8, 0.4, 0, 0.2, 1.5;
  const HexShape shape = make_hex_shape(affine(box_nodes({1, 1, 1}), A), 0.3);
  const Vector8d volumes = node_volumes(shape);
  CHECK((volumes.array() - A.determinant() / 8).abs().maxCoeff() < 1e-15);
  const HexQuality quality = hex_quality(shape.rest_nodes);
  CHECK(quality.determinant_ratio == Approx(1).epsilon(1e-12));
  CHECK(quality.scaled_jacobian < 0.99);
  CHECK(hex_quality(box_nodes({3, 2, 1})).scaled_jacobian == Approx(1).epsilon(1e-15));
}

TEST_CASE("the beam of distorted hexes sags as the regular one, within 2 %") {
  const Swing regular = swing(distorted_beam(0), 130);
  REQUIRE(regular.lowest < -0.5);
  const std::uint64_t seed = GENERATE(1u, 2u);
  Body beam = make_beam();
  beam.lattice = distorted_lattice(beam.lattice, 0.3, seed);
  const Swing distorted = swing(beam, 130);
  const double first_swing = distorted.lowest / regular.lowest - 1;

  Body damped = distorted_beam(0);
  damped.material.damping_mass = 4;
  beam.material.damping_mass = 4;
  const double settled = swing(beam, 500).settled / swing(damped, 500).settled - 1;
  CAPTURE(seed, first_swing, settled, regular.lowest);
  CHECK(std::abs(first_swing) < 0.02);
  CHECK(std::abs(settled) < 0.02);
  CHECK(std::abs(settled) > 1e-6);  // the meshes do differ
}

TEST_CASE("limits hold in distorted hexes") {
  Body beam = distorted_beam(0.25);
  limit_energy(beam, 0.1);
  const Swing result = swing(beam, 120);
  CHECK(result.all_converged);
  CHECK(result.max_ratio > 0.99);
  CHECK(result.max_ratio < 1.001);
}

TEST_CASE("every hex is held to its own limit") {
  Body beam = make_beam();
  limit_energy(beam, 0.5);
  beam.limit_factor = VectorXd::Ones(56);
  beam.limit_factor.head(28).setConstant(0.1);  // the clamped half
  const Model model = make_model({beam}, {});
  CHECK(energy_limit_at(model, 0, 0) == 0.5 * 0.1);
  CHECK(energy_limit_at(model, 55, 0) == 0.5);

  const StepOptions options{.time_step = 0.01};
  State state = rest_state(model);
  double weak = 0, strong = 0;  // [J] most in a hex of either half
  double worst = 0;             // [-] U_e / U_max,e recomputed hex by hex
  simulate(model, options, 120, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    for (Eigen::Index e = 0; e < 56; ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const double energy = elastic_energy(
          shape.stiffness, 150e3, corotate(shape, RotationEstimate::centre, hex_nodes(model, now.positions, e)));
      (e < 28 ? weak : strong) = std::max(e < 28 ? weak : strong, energy);
      worst = std::max(worst, energy / (e < 28 ? 0.05 : 0.5));
    }
  });
  CHECK(worst < 1.001);
  CHECK(worst > 0.99);
  CHECK(weak < 0.05 * 1.001);
  CHECK(strong > 2 * weak);
}

TEST_CASE("every hex has its own stiffness, and a limit on stretch follows it") {
  Body block = make_block({2, 1, 1}, Vector3d::Zero(), 0.5);
  block.material.young = 1e5;
  block.young_factor = VectorXd{{1, 3}};
  block.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.2};
  const Model model = make_model({block}, {});
  CHECK(young_at(model, 0, 0) == 1e5);
  CHECK(young_at(model, 1, 0) == 3e5);
  CHECK(energy_limit_at(model, 1, 0) == Approx(3 * energy_limit_at(model, 0, 0)));
}

TEST_CASE("factors that cannot be used are refused by the name of body and hex") {
  Body body = make_block({2, 1, 1}, Vector3d::Zero(), 0.5);
  body.limit_factor = VectorXd{{1, 0}};
  CHECK(complaint(body).find("body.block.limit_factor of hex 1: must be positive and finite") == 0);
  body.limit_factor = VectorXd{{std::nan(""), 1}};
  CHECK(complaint(body).find("limit_factor of hex 0") != std::string::npos);
  body.limit_factor = VectorXd{{1, 1, 1}};
  CHECK(complaint(body).find("one factor per hex") != std::string::npos);
  body.limit_factor.resize(0);
  body.young_factor = VectorXd{{-1, 1}};
  CHECK(complaint(body).find("young_factor of hex 0") != std::string::npos);
  body.young_factor = VectorXd{{2, 1}};
  CHECK(complaint(body).empty());
}

TEST_CASE("an inverted hex of an irregular body is named") {
  Body body = irregular_block(0.1);
  body.lattice.rest_positions.row(body.lattice.hexes(13, 0)) =
      body.lattice.rest_positions.row(body.lattice.hexes(13, 7)) + Eigen::RowVector3d(0.05, 0.05, 0.05);
  const std::string text = complaint(body);
  CHECK(text.find("body.block.cage") == 0);
  CHECK(text.find("hex ") != std::string::npos);
}
