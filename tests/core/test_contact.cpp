// What touches: obstacles of all shapes, edges, presses, starts in penetration. No vertex may end a step deeper than
// 1e-3 of the cell size.
#include "core/contact/contact.h"

#include <map>

#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

std::shared_ptr<SampledDistance> sampled_ball(double radius) {
  return test::sample_distance([radius](const Vector3d& p) { return p.norm() - radius; }, Vector3d::Constant(-radius),
                               Vector3d::Constant(radius), radius / 12);
}

Body soft_block(const Vector3d& origin) {
  Body body = test::make_block({3, 3, 3}, origin, 0.1, 4);
  body.material.young = 3e4;
  body.friction = 0.3;
  return body;
}

Body with_rest_distance(Body body, const Vector3d& low, const Vector3d& high) {
  body.rest_distance =
      test::sample_distance([=](const Vector3d& p) { return test::box_distance(p, low, high); }, low, high, 0.025);
  return body;
}

StepOptions options_for(SolverMethod method) {
  StepOptions options{.time_step = 0.01};
  options.solver.method = method;
  options.solver.tolerance = 1e-2;
  return options;
}

struct Run {
  double deepest = 0;  // [m] over all steps
  int most_contacts = 0;
  double highest_speed = 0;   // [m/s]
  double highest_energy = 0;  // [J] kinetic + elastic + potential
  StepReport last;
  State state;
};

Run run(const Model& model, const StepOptions& options, int steps) {
  Run result;
  result.state = rest_state(model);
  result.highest_energy = -1e300;
  test::simulate(model, options, steps, result.state, [&](const StepReport& report, const State& now) {
    result.deepest = std::max(result.deepest, report.max_penetration);
    result.most_contacts = std::max(result.most_contacts, report.contacts);
    result.highest_speed = std::max(result.highest_speed, now.velocities.rowwise().norm().maxCoeff());
    result.highest_energy =
        std::max(result.highest_energy, report.kinetic_energy + report.elastic_energy + report.potential_energy);
    result.last = report;
  });
  return result;
}

}  // namespace

TEST_CASE("no vertex of a falling block ends a step deeper than a thousandth of a cell") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const int shape = GENERATE(0, 1, 2, 3);
  const std::vector<ObstacleShape> shapes{HalfSpace{}, Ball{0.4}, Block{{0.4, 0.4, 0.4}},
                                          MeshShape{sampled_ball(0.4), Points(0, 3)}};
  CAPTURE(int(method), shape);
  Obstacle obstacle{.name = "obstacle", .shape = shapes[shape], .friction = 0.3};
  if (shape > 0) obstacle.position = Track<Vector3d>(Vector3d(0.05, -0.4, 0.02));
  Body body = soft_block({-0.15, 0.05, -0.15});
  body.velocity = {0, -2, 0};
  const Model model = make_model({body}, {obstacle});
  const Run result = run(model, options_for(method), 40);
  CHECK(result.most_contacts >= 3);
  CHECK(result.deepest <= 1e-3 * 0.1);
}

TEST_CASE("a block that falls across a box's edge is held by the edge between its vertices") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const bool corner = GENERATE(false, true);
  CAPTURE(int(method), corner);
  // a roof's ridge, or a cube's corner, under the middle of a block whose vertices are only its corners
  const Vector3d low(-0.2, 0.02, -0.2), high(0.2, 0.42, 0.2);
  Body body = with_rest_distance(test::make_block({4, 4, 4}, low, 0.1, 1), low, high);
  Points eight(8, 3);
  for (int n = 0; n < 8; ++n)
    eight.row(n) << (n & 1 ? low : high).x(), (n & 2 ? low : high).y(), (n & 4 ? low : high).z();
  body.surface_rest = eight;
  body.surface = test::embed_in_box(body.lattice, {4, 4, 4}, eight);
  body.material.young = 2e5;
  body.material.damping_mass = 2;
  Obstacle box{.name = "box", .shape = Block{{0.3, 0.3, 0.3}}, .friction = 0.8};
  if (corner) {
    box.rotation_degrees = Track<Vector3d>(Vector3d(45, 0, 35.26438968));
    box.position = Track<Vector3d>(Vector3d(0, -0.3 * std::sqrt(3.0), 0));
  } else {
    box.rotation_degrees = Track<Vector3d>(Vector3d(45, 0, 0));
    box.position = Track<Vector3d>(Vector3d(0, -0.3 * std::sqrt(2.0), 0));
  }
  const Model model = make_model({body}, {box});
  const Run result = run(model, options_for(method), 60);
  const Vector3d centre = test::mean_of(model.node_mass, result.state.positions);
  CHECK(result.most_contacts >= 1);
  CHECK(centre.y() > 0.1);  // without the edge it would have fallen 1.8 m
  CHECK(result.highest_speed < 3);
}

TEST_CASE("of a flat face's vertices, which are all as deep, the first of each hex is held, however they are grouped") {
  Body body = soft_block({-0.15, 0.01, -0.15});
  constexpr int per_edge = 24;  // 64 vertices a hex, 16 a group
  body.surface_rest.resize(per_edge * per_edge, 3);
  for (int p = 0; p < per_edge * per_edge; ++p) {
    const int place = p * 101 % (per_edge * per_edge);  // here and there
    body.surface_rest.row(p) << -0.15 + 0.3 * (place / per_edge + 0.5) / per_edge, 0.01,
        -0.15 + 0.3 * (place % per_edge + 0.5) / per_edge;
  }
  body.surface = test::embed_in_box(body.lattice, {3, 3, 3}, body.surface_rest);
  const Model model = make_model({body}, {test::make_ground(0.5)});
  std::map<int, int> first;  // of each hex
  for (int p = 0; p < int(model.num_points()); ++p) first.try_emplace(surface_hex(model, p), p);
  const ContactGeometry geometry = make_contact_geometry(model);
  const ContactStep step =
      begin_contact_step(model, geometry, model.rest_positions, model.rest_positions, 0, 0.01, 9.81);
  Points down = model.rest_positions;
  down.col(1).array() -= 0.02;
  std::vector<Contact> contacts;
  REQUIRE(add_contacts(step, LastApart(down), down, 0.5, contacts) == 9);
  for (const Contact& contact : contacts) CHECK(contact.point.index == first.at(contact.support.hex));
}

TEST_CASE("a press squeezes a block by as much as it closes") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  Body body = soft_block({-0.15, 0, -0.15});
  body.material.damping_stiffness = 0.02;
  Obstacle press{.name = "press", .shape = Block{{0.5, 0.1, 0.5}}, .friction = 0.5};
  press.position.times = {0, 0.5};
  press.position.values = {Vector3d(0, 0.42, 0), Vector3d(0, 0.32, 0)};
  const Model model = make_model({body}, {test::make_ground(0.5), press});
  const Run result = run(model, options_for(method), 60);
  CHECK(result.deepest <= 1e-3 * 0.1);
  CHECK(result.state.positions.col(1).maxCoeff() < 0.22 + 2e-4);
  CHECK(result.state.positions.col(1).minCoeff() > -2e-4);
}

TEST_CASE("a start in penetration is pushed out gently") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  const double depth = GENERATE(0.03, 0.12);
  CAPTURE(int(method), depth);
  Body body = soft_block({-0.15, -depth, -0.15});
  const Model model = make_model({body}, {test::make_ground(0.3)});
  const StepOptions options = options_for(method);
  CHECK(measure(model, options, rest_state(model)).max_penetration == Approx(depth));
  const double fall_through_a_cell = std::sqrt(9.81 * 0.1);
  const Run result = run(model, options, 100);
  CHECK(result.last.max_penetration <= 1e-3 * 0.1);
  CHECK(result.highest_speed < 2 * fall_through_a_cell);
  // at most the work of lifting it out and the motion at the recovery speed
  const double weight = test::total_mass(model) * 9.81;
  const StepReport start = measure(model, options, rest_state(model));
  CHECK(result.highest_energy < start.potential_energy + weight * (depth + 0.1));
}

TEST_CASE("a start in penetration is pushed out without gravity, too") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  Body body = soft_block({-0.15, -0.02, -0.15});
  const Model model = make_model({body}, {test::make_ground(0.3)});
  StepOptions options = options_for(method);
  options.gravity.setZero();
  const Run result = run(model, options, 60);
  CHECK(result.last.max_penetration <= 1e-3 * 0.1);
  CHECK(result.highest_speed < 2);
}

TEST_CASE("a resting block's contact impulses carry its weight") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  Body body = soft_block({-0.15, 0, -0.15});
  body.material.damping_stiffness = 0.02;
  const Model model = make_model({body}, {test::make_ground(0.3)});
  const Run result = run(model, options_for(method), 150);
  Vector3d impulse = Vector3d::Zero();
  for (const State::ContactImpulse& contact : result.state.contacts) impulse += contact.impulse;
  const Vector3d weight(0, test::total_mass(model) * 9.81 * 0.01, 0);
  CHECK((impulse - weight).norm() < 0.01 * weight.norm());
}

TEST_CASE("a dense flat surface at rest is held by a few contacts per hex") {
  const auto method = GENERATE(SolverMethod::paper, SolverMethod::exact);
  Body body = test::make_block({6, 2, 6}, {0, 0.001, 0}, 0.1, 12);
  body.material.young = 2e5;
  const Model model = make_model({body}, {test::make_ground(0.5)});
  const Run result = run(model, options_for(method), 30);
  CHECK(result.most_contacts <= 100);
  CHECK(result.deepest <= 1e-3 * 0.1);
}

TEST_CASE("detection names the deepest vertex of each touching hex") {
  const Body body = test::make_block({2, 1, 1}, {0, -0.01, 0}, 0.1, 3);
  const Model model = make_model({body}, {test::make_ground()});
  const ContactGeometry geometry = make_contact_geometry(model);
  State state = rest_state(model);
  // tilt: the first hex is deepest at x = 0
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) state.positions(i, 1) += 0.04 * state.positions(i, 0);
  Points above = state.positions;
  above.col(1).array() += 0.1;  // it came from above: no start in penetration
  const ContactStep contact_step = begin_contact_step(model, geometry, above, above, 0, 0.01, 9.81);
  std::vector<Contact> contacts;
  REQUIRE(add_contacts(contact_step, LastApart(state.positions), state.positions, 0.5, contacts) == 2);
  for (const Contact& contact : contacts) {
    const double hex_start = contact.support.hex == 0 ? 0 : 0.1;
    CHECK(contact.gap == Approx(-0.01 + 0.04 * hex_start).margin(0.04 * 0.035));
    CHECK((contact.normal - Vector3d::UnitY()).norm() < 1e-15);
    const Vector3d at = embedded_position(model, state.positions, contact.support);
    CHECK(at.y() == Approx(contact.gap));
  }
  CHECK(max_penetration(model, geometry, state.positions, 0) == Approx(0.01));
}

TEST_CASE("gaps followed along their normals are those of a fresh detection for a small motion") {
  // the box's upper edges stick in the block's bottom, the block's vertices in the box's top
  const Vector3d low(-0.2, 0, -0.2), high(0.2, 0.4, 0.2);
  const Body body = with_rest_distance(test::make_block({4, 4, 4}, low, 0.1, 3), low, high);
  Obstacle box{.name = "box", .shape = Block{{0.13, 0.5, 0.13}}, .friction = 0.3};
  box.position = Track<Vector3d>(Vector3d(0, -0.498, 0));
  const Model model = make_model({body}, {box});
  const ContactGeometry geometry = make_contact_geometry(model);
  Points above = model.rest_positions, moved = model.rest_positions;
  above.col(1).array() += 0.1;
  moved.rowwise() += Vector3d(1e-4, -3e-4, 2e-4).transpose();
  const ContactStep contact_step = begin_contact_step(model, geometry, above, above, 0, 0.01, 9.81);
  std::vector<Contact> contacts;
  add_contacts(contact_step, LastApart(model.rest_positions), model.rest_positions, 0.5, contacts);
  int edges = 0;
  for (const Contact& contact : contacts) edges += contact.point.kind == ContactKind::obstacle_edge;
  REQUIRE(edges > 0);
  REQUIRE(edges < int(contacts.size()));
  std::vector<Contact> followed = contacts, fresh = contacts;
  follow_contacts(contact_step, moved, followed);
  update_contacts(contact_step, LastApart(moved), moved, fresh);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    CHECK(contacts[i].gap == Approx(-0.002).margin(1e-6));
    CHECK(fresh[i].gap == Approx(-0.0023).margin(1e-6));
    CHECK(followed[i].gap == Approx(fresh[i].gap).margin(1e-6));
  }
}

TEST_CASE("a vertex keeps of the depth that it starts with what leaves room for what a step may add, and no more") {
  constexpr double cell = 0.1, tolerance = 1e-3 * cell;
  const double depth = GENERATE(0.3, 0.9);  // [tolerances]
  CAPTURE(depth);
  const Model model =
      make_model({test::make_block({2, 2, 2}, {0, -depth * tolerance, 0}, cell)}, {test::make_ground()});
  const ContactGeometry geometry = make_contact_geometry(model);
  const Points positions = rest_state(model).positions;
  std::vector<Contact> contacts;
  add_contacts(begin_contact_step(model, geometry, positions, positions, 0, 0.01, 9.81), LastApart(positions),
               positions, 0, contacts);
  REQUIRE(contacts.size() == 4);  // hexes that touch
  for (const Contact& contact : contacts)
    CHECK(contact.gap / tolerance == Approx(-std::max(0.0, depth - 0.5)).margin(1e-9));
}
