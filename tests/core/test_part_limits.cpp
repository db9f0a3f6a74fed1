// Limits on parts of the energy and on its peak, in whole simulations.
#include <tbb/global_control.h>

#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/model/hex_limits.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

constexpr double poisson = 0.3;

EnergyLimitOptions hard(double stretch, LimitMeasure measure = LimitMeasure::mean) {
  return {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = stretch, .measure = measure};
}

// a tall block that hangs from its upper face
Body hanging_block(const Vector3i& cells, double young) {
  Body block = test::make_block(cells, {0, 0, 0}, 0.1);
  block.material.young = young;
  block.material.poisson = poisson;
  block.material.damping_mass = 6;
  for (int node = 0; node < int(block.lattice.num_nodes()); ++node)
    if (block.lattice.rest_positions(node, 1) > 0.1 * cells[1] - 1e-9) block.fixed_nodes.push_back(node);
  return block;
}

StepOptions options_with(double gravity = 9.81) {
  return {.time_step = 0.02, .gravity = {0, -gravity, 0}};
}

struct Run {
  State state;
  double highest_ratio = 0, highest_residual = 0;
  int most_active = 0;
};

Run run(const Model& model, const StepOptions& options, int steps) {
  Run result{.state = rest_state(model)};
  test::simulate(model, options, steps, result.state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    result.highest_ratio = std::max(result.highest_ratio, report.max_energy_ratio);
    result.highest_residual = std::max(result.highest_residual, report.kkt_residual);
    result.most_active = std::max(result.most_active, report.limits_active);
  });
  return result;
}

// every limit kind that a body may have, each alone
std::map<std::string, Body> each_limit(const Body& body, double stretch) {
  std::map<std::string, Body> bodies;
  for (const LimitMeasure measure : {LimitMeasure::mean, LimitMeasure::peak}) {
    const std::string name = measure == LimitMeasure::mean ? "mean " : "peak ";
    (bodies[name + "whole"] = body).limit = hard(stretch, measure);
    (bodies[name + "volumetric"] = body).part_limits.volumetric = hard(stretch, measure);
    (bodies[name + "deviatoric"] = body).part_limits.deviatoric = hard(stretch, measure);
    (bodies[name + "fibre"] = body).part_limits.fibre = hard(stretch, measure);
    bodies[name + "fibre"].part_limits.fibre_direction = {1, 1, 0};
  }
  return bodies;
}

// mean size along an axis of the block's nodes in its middle layer, over that at rest
double extent(const Model& model, const Points& positions, int axis) {
  const VectorXd rest = model.rest_positions.col(axis);
  double now = 0, before = 0;
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) {
    const double side = rest[i] > rest.maxCoeff() - 1e-9 ? 1 : rest[i] < rest.minCoeff() + 1e-9 ? -1 : 0;
    now += side * positions(i, axis);
    before += side * rest[i];
  }
  return now / before;
}

}  // namespace

TEST_CASE("each limit by itself holds in a swinging beam, and a step's residual is small") {
  for (const auto& [name, beam] : each_limit(test::make_beam(), 0.05)) {
    CAPTURE(name);
    const Run result = run(make_model({beam}, {}), {.time_step = 0.01}, 50);
    CHECK(result.highest_ratio <= 1.001);
    CHECK(result.highest_ratio > 0.999);
    CHECK(result.highest_residual <= 1e-3);
    CHECK(result.most_active > 3);
    CHECK(result.most_active <= 56);
  }
}

TEST_CASE("the list of limits is grouped by hex, in order of parts and points, and equal hexes share forms") {
  Body block = test::make_block({2, 2, 1}, {0, 0, 0}, 0.1), other = block;
  block.limit = hard(0.1);
  block.part_limits.volumetric = hard(0.2, LimitMeasure::peak);
  block.part_limits.fibre = hard(0.3);
  other.name = "other";
  other.lattice.rest_positions.col(0).array() += 5;
  other.part_limits.deviatoric = hard(0.1);
  const Model model = make_model({block, other, test::make_beam()}, {});
  REQUIRE(model.limits.size() == 4 * 10 + 4);
  REQUIRE(model.limit_starts.size() == model.num_hexes() + 1);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    for (int l = model.limit_starts[e]; l < model.limit_starts[e + 1]; ++l) CHECK(model.limits[l].hex == e);
  CHECK(model.limits[0].part == EnergyPart::whole);
  CHECK(model.limits[0].form == -1);
  CHECK(model.limits[8].part == EnergyPart::volumetric);
  CHECK(model.limits[9].part == EnergyPart::fibre);
  CHECK(model.limit_forms.size() == 8 + 1 + 1);
  CHECK(rest_state(model).limit_multipliers.size() == 44);

  block.fibre_directions.setOnes(4, 3);
  CHECK(make_model({block}, {}).limit_forms.size() == 8 + 4);
}

TEST_CASE("a fibre direction for each hex is the same as one for all where they are equal") {
  Body beam = test::make_beam();
  beam.part_limits.fibre = hard(0.05);
  beam.part_limits.fibre_direction = {3, 0, 1};
  const State uniform = test::simulate(make_model({beam}, {}), {.time_step = 0.01}, 30);
  beam.fibre_directions = Vector3d(3, 0, 1).transpose().replicate(56, 1);
  beam.part_limits.fibre_direction = {0, 1, 0};  // not read
  CHECK(test::simulate(make_model({beam}, {}), {.time_step = 0.01}, 30).positions == uniform.positions);
}

TEST_CASE("directions that are none are refused with their place") {
  Body block = test::make_block({2, 1, 1}, {0, 0, 0}, 0.1);
  block.part_limits.fibre = hard(0.1);
  block.part_limits.fibre_direction.setZero();
  CHECK(test::complaint(block).find("body.block.limit.fibre.direction") == 0);
  block.part_limits.fibre_direction = {0, 1, 0};
  CHECK(test::complaint(block).empty());
  block.fibre_directions.setOnes(3, 3);
  CHECK(test::complaint(block).find("body.block.fibre_directions") == 0);
  block.fibre_directions.setZero(2, 3);
  CHECK(test::complaint(block).find("body.block.fibre_directions of hex 0") == 0);
  block.fibre_directions.setOnes(2, 3);
  block.part_limits.fibre.value = -0.1;
  CHECK(test::complaint(block).find("body.block.limit.fibre: ") == 0);
}

TEST_CASE("the paper's energy has no parts and no peaks: an error names the limit") {
  for (const auto& [name, beam] : each_limit(test::make_beam(), 0.05)) {
    CAPTURE(name);
    const Model model = make_model({beam}, {});
    StepOptions options;
    options.solver.energy = EnergyMeasure::paper;
    State state = rest_state(model);
    Workspace workspace(model);
    if (name == "mean whole")
      CHECK_NOTHROW(step(model, options, workspace, state));
    else
      CHECK_THROWS_AS(step(model, options, workspace, state), Error);
  }
}

TEST_CASE("a hanging block stops along its fibre and elongates across as if it had none") {
  // fibres along the pull stop it at their stretch; fibres across it leave the pull alone
  Body block = hanging_block({1, 6, 1}, 20e3);
  const double free_stretch =
      extent(make_model({block}, {}), run(make_model({block}, {}), options_with(), 150).state.positions, 1) - 1;
  const auto stretch_with = [&](const Vector3d& direction) {
    Body limited = block;
    limited.part_limits.fibre = hard(0.03);
    limited.part_limits.fibre_direction = direction;
    const Model model = make_model({limited}, {});
    const Run result = run(model, options_with(), 150);
    CHECK(result.highest_ratio <= 1.001);
    return extent(model, result.state.positions, 1) - 1;
  };
  const double along = stretch_with({0, 1, 0}), across = stretch_with({1, 0, 0});
  CAPTURE(free_stretch, along, across);
  CHECK(free_stretch > 0.06);
  CHECK(along < 0.031);  // no hex beyond 3 %
  CHECK(along > 0.024);  // the upper five are at it, the lowest hangs on nothing
  CHECK(across == Approx(free_stretch).epsilon(0.05));
}

TEST_CASE("a volumetric limit keeps a pressed block's volume and lets it spread instead") {
  // a press closes on a soft block between frictionless plates
  const auto pressed = [](bool limited) {
    Body block = test::make_block({3, 3, 3}, {-0.15, 0, -0.15}, 0.1, 1);
    block.material.young = 2e4;
    block.material.poisson = 0.1;
    block.material.damping_mass = 10;
    block.friction = 0;
    if (limited)
      block.part_limits.volumetric = {
          .kind = LimitKind::hard, .unit = LimitUnit::density, .value = 0.5 * 2e4 / 2.4 * 1e-4};
    Obstacle press{.name = "press", .shape = Block{{1, 0.1, 1}}};
    press.position = Track<Vector3d>(Vector3d(0, 0.4, 0));
    press.position.times = {0, 1};
    press.position.values = {{0, 0.4, 0}, {0, 0.34, 0}};
    const Model model = make_model({block}, {test::make_ground(), press});
    const Run result = run(model, options_with(0), 75);
    CHECK(result.highest_ratio <= 1.001);
    const Points& x = result.state.positions;
    return Vector3d(extent(model, x, 0), extent(model, x, 1), extent(model, x, 2));
  };
  const Vector3d free = pressed(false), limited = pressed(true);
  CAPTURE(free.transpose(), limited.transpose());
  CHECK(free.y() == Approx(0.8).margin(0.005));
  CHECK(limited.y() == Approx(0.8).margin(0.005));
  // tr eps = 1 % at most against -0.2 (1 - 2 v) without
  CHECK((free - Vector3d::Ones()).sum() == Approx(-0.2 * (1 - 2 * 0.1)).margin(0.005));
  CHECK(std::abs((limited - Vector3d::Ones()).sum()) < 0.0101);
  CHECK(limited.x() > free.x() + 0.05);
}

TEST_CASE("a peak limit holds where bending hides behind the mean") {
  const auto bent = [](LimitMeasure measure) {
    Body beam = test::make_beam();
    beam.limit = hard(0.05, measure);
    beam.material.damping_mass = 4;
    const Model model = make_model({beam}, {});
    const Run result = run(model, {.time_step = 0.02}, 120);
    CHECK(result.highest_ratio <= 1.001);
    // the largest density of all points as stretch
    double largest = 0;
    for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const CorotatedHex hex = corotate(shape, RotationEstimate::centre, hex_nodes(model, result.state.positions, e));
      for (int q = 0; q < 8; ++q)
        largest = std::max(
            largest, elastic_energy(part_stiffness_at(shape, EnergyPart::whole, Vector3d::UnitX(), q), 150e3, hex) /
                         shape.volume);
    }
    return std::pair(result.state.positions(test::beam_tip(), 1) - 0.06, std::sqrt(2 * largest / 150e3));
  };
  const auto [mean_tip, mean_stretch] = bent(LimitMeasure::mean);
  const auto [peak_tip, peak_stretch] = bent(LimitMeasure::peak);
  CAPTURE(mean_tip, mean_stretch, peak_tip, peak_stretch);
  CHECK(peak_stretch <= 0.05 * 1.0006);
  CHECK(mean_stretch > 0.06);
  CHECK(peak_tip > mean_tip + 0.03);
}

TEST_CASE("parts and peaks hold in irregular hexes, too") {
  Body base = test::make_beam();
  for (Eigen::Index i = 0; i < base.lattice.num_nodes(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      base.lattice.rest_positions(i, axis) += 0.008 * std::sin(double(37 * i + 11 * axis));
  base.lattice.cells.resize(0, 3);
  for (const auto& [name, beam] : each_limit(base, 0.03)) {
    CAPTURE(name);
    const Run result = run(make_model({beam}, {}), {.time_step = 0.01}, 30);
    CHECK(result.highest_ratio <= 1.001);
    CHECK(result.most_active > 3);
  }
}

TEST_CASE("where the SQP gives up, the line search holds parts and peaks together") {
  Body sphere = test::make_sphere(3, {0, 1.05, 0});
  sphere.velocity = {1, -4, 0};
  sphere.part_limits.volumetric = hard(0.05);
  sphere.part_limits.fibre = hard(0.05);
  sphere.part_limits.fibre_direction = {0, 1, 0};
  sphere.limit = hard(0.2, LimitMeasure::peak);
  const Model model = make_model({sphere}, {test::make_ground(0.5)});
  StepOptions options{.time_step = 0.01};
  const State usual = run(model, options, 15).state;
  options.solver.max_newton_iterations = 1;
  options.solver.max_halvings = 0;
  const Run searched = run(model, options, 15);
  CHECK(searched.highest_ratio <= 1.001);
  CHECK((searched.state.positions - usual.positions).cwiseAbs().maxCoeff() < 5e-3);
}

TEST_CASE("the paper's method holds parts and peaks to its tolerance") {
  for (const auto& [name, beam] : each_limit(test::make_beam(), 0.08)) {
    CAPTURE(name);
    StepOptions options{.time_step = 0.01};
    options.solver.method = SolverMethod::paper;
    options.solver.tolerance = 1e-2;
    const Run result = run(make_model({beam}, {}), options, 30);
    CHECK(result.highest_ratio <= 1.01);
    CHECK(result.highest_ratio > 0.99);
  }
}

TEST_CASE("a soft limit on a part or a peak lets it pass by little") {
  for (auto [name, beam] : each_limit(test::make_beam(), 0.08)) {
    CAPTURE(name);
    for (EnergyLimitOptions* limit :
         {&beam.limit, &beam.part_limits.volumetric, &beam.part_limits.deviatoric, &beam.part_limits.fibre})
      if (limit->kind == LimitKind::hard) limit->kind = LimitKind::soft;
    const Run result = run(make_model({beam}, {}), {.time_step = 0.01}, 40);
    CHECK(result.highest_ratio > 0.7);
    CHECK(result.highest_ratio < 1.02);
  }
}

TEST_CASE("an impact with limits on parts and peaks is bit-identical for 1 and 2 threads") {
  const auto impact = [](std::size_t threads, SolverMethod method) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    Body body = test::make_sphere(5, {0, 1.05, 0}, 1000);
    body.velocity = {1, -4, 0};
    body.limit = hard(0.15, LimitMeasure::peak);
    body.part_limits.volumetric = hard(0.1);
    const Model model = make_model({body}, {test::make_ground(0.5)});
    StepOptions options{.time_step = 0.01};
    options.solver.method = method;
    options.solver.tolerance = 1e-2;
    const Run result = run(model, options, 10);
    CHECK(result.most_active > 5);
    return result.state;
  };
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const State one = impact(1, method), two = impact(2, method);
  CHECK(one.positions == two.positions);
  CHECK(one.limit_multipliers == two.limit_multipliers);
}

TEST_CASE("a keyframed limit on a part is followed") {
  Body beam = test::make_beam();
  beam.material.damping_mass = 4;
  beam.part_limits.deviatoric = hard(0.1);
  beam.part_limits.deviatoric.value.times = {0, 1};
  beam.part_limits.deviatoric.value.values = {0.1, 0.03};
  const Model model = make_model({beam}, {});
  CHECK(energy_limit_at(model, 0, 1, EnergyPart::deviatoric) ==
        Approx(0.5 * 150e3 * 0.03 * 0.03 * 2 * 1.3 / 3 * model.shapes[0].volume));
  const Run result = run(model, {.time_step = 0.01}, 130);
  CHECK(result.highest_ratio <= 1.001);
  CHECK(result.most_active > 10);
}
