// Bodies that touch each other and themselves.
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/contact/contact_support.h"
#include "core/contact/held_vertex.h"
#include "core/contact/surface_contact.h"
#include "core/step/newton_system.h"
#include "embedding/surface/shapes.h"
#include "tests/support/begun_step.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

TEST_CASE("two free blocks that collide keep their momentum and do not pass through each other") {
  const LinearSolver linear = GENERATE(LinearSolver::direct, LinearSolver::multigrid);
  CAPTURE(int(linear));
  Body left = touchable_block("left", {2, 2, 2}, {0, 0, 0}, 0.1);
  Body right = touchable_block("right", {2, 2, 2}, {0.21, 0.05, 0.03}, 0.1);
  left.velocity = {1, 0, 0};
  right.velocity = {-1, 0, 0};
  right.material.density = 800;
  const Model model = make_model({left, right}, {});
  StepOptions options = without_gravity();
  options.solver.linear = linear;
  State state = rest_state(model);
  const Vector3d before = test::momentum(model, state);
  const double size = (model.node_mass.transpose() * state.velocities.rowwise().norm()).value();
  int contacts = 0;
  test::simulate(model, options, 30, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    contacts = std::max(contacts, report.contacts);
    CHECK((test::momentum(model, now) - before).norm() <
          (linear == LinearSolver::direct ? 1e-8 : options.solver.tolerance) * size);
    CHECK(report.max_penetration < 2e-3 * 0.1);
  });
  CHECK(contacts > 0);
  // at this time step nearly all of the bounce is lost
  CHECK(state.velocities.topRows(27).col(0).mean() == Approx(before.x() / test::total_mass(model)).margin(0.1));
  CHECK(state.velocities.bottomRows(27).col(0).mean() == Approx(before.x() / test::total_mass(model)).margin(0.1));
}

TEST_CASE("a block comes to rest on another one, whichever is listed first") {
  const bool reversed = GENERATE(false, true);
  Body low = touchable_block("low", {3, 2, 3}, {0, 0.0, 0}, 0.1);
  Body high = touchable_block("high", {2, 2, 2}, {0.05, 0.21, 0.05}, 0.1);
  for (Body* body : {&low, &high}) body->material.damping_mass = 5;
  const std::vector<Body> bodies = reversed ? std::vector{high, low} : std::vector{low, high};
  const Model model = make_model(bodies, {test::make_ground(0.5)});
  StepOptions options;
  State state = rest_state(model);
  test::simulate(model, options, 150, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_penetration < 2e-3 * 0.1);
  });
  const int below = reversed ? 1 : 0;
  CHECK(state.velocities.rowwise().norm().maxCoeff() < 5e-3);
  CHECK(lowest_of(model, state, 1 - below) == Approx(highest_of(model, state, below)).margin(2e-3));
  CHECK(lowest_of(model, state, 1 - below) > 0.15);
}

TEST_CASE("a ball comes to rest on a block that is held as a whole") {
  Body block = touchable_block("block", {3, 1, 3}, {0, 0, 0}, 0.1);
  for (int node = 0; node < int(block.lattice.num_nodes()); ++node) block.fixed_nodes.push_back(node);
  const Model model = make_model({block, touchable_ball("ball", 3, {0.15, 0.24, 0.15}, 0.1)}, {});
  State state = rest_state(model);
  simulate(model, StepOptions(), 40, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_penetration < 1e-4);
    CHECK(now.positions.topRows(model.bodies[1].first_node) ==
          model.rest_positions.topRows(model.bodies[1].first_node));
  });
  CHECK(!state.contacts.empty());
}

TEST_CASE("the depth that a step reports is that of all bodies, though pairs of them are solved apart") {
  std::vector<Body> bodies;
  for (const double x : {0.0, 5.0}) {
    bodies.push_back(touchable_block(x > 0 ? "b" : "a", {3, 1, 3}, {x, 0, 0}, 0.1));
    for (int node = 0; node < int(bodies.back().lattice.rest_positions.rows()); ++node)
      bodies.back().fixed_nodes.push_back(node);
    bodies.push_back(touchable_ball(x > 0 ? "d" : "c", 3, {x + 0.15, x > 0 ? 0.23 : 0.24, 0.15}, 0.12));
  }
  const Model model = make_model(std::move(bodies), {});
  const StepOptions options;
  Workspace workspace(model);
  State state = rest_state(model);
  int touched = 0;
  for (int i = 0; i < 8; ++i) {
    const StepReport report = step(model, options, workspace, state);
    CHECK(report.max_penetration == measure(model, options, state).max_penetration);
    touched += report.max_penetration > 0;
  }
  CHECK(touched > 3);
}

TEST_CASE("bodies that may not touch pass through each other") {
  Body left = touchable_block("left", {2, 2, 2}, {0, 0, 0}, 0.1);
  Body right = touchable_block("right", {2, 2, 2}, {0.25, 0, 0}, 0.1);
  left.velocity = {2, 0, 0};
  std::vector<BodyPair> pairs;
  SECTION("one of them says so") {
    right.contact = ContactWith::obstacles;
  }
  SECTION("the pair says so") {
    pairs.push_back({.a = 1, .b = 0, .touch = false, .friction = {}});
  }
  SECTION("neither has an inside") {
    left.rest_surface = right.rest_surface = nullptr;
  }
  const Model model = make_model({left, right}, {}, pairs);
  const State state = test::simulate(model, without_gravity(), 15);
  CHECK(state.positions.topRows(27).col(0).mean() == Approx(0.1 + 2 * 15 / 60.0));
}

TEST_CASE("two parts of one body touch, unless it is told not to touch itself") {
  // two blocks of a cage that share no node, the upper one falls on the lower one
  const double cell = 0.1;
  Cells cells(16, 3);
  std::vector<Vector3d> points;
  for (int part = 0, e = 0; part < 2; ++part)
    for (int i = 0; i < 8; ++i) cells.row(e++) << (i >> 2 & 1), (i >> 1 & 1) + 4 * part, (i & 1);
  Body body;
  body.lattice = make_lattice(cells, Vector3d::Zero(), Vector3d::Constant(cell));
  body.material.mass = MassModel::lattice;
  TriangleMesh mesh = make_box({0.2, 0.2, 0.2});
  const Eigen::Index count = mesh.positions.rows();
  Points positions(2 * count, 3);
  Triangles triangles(2 * mesh.triangles.rows(), 3);
  for (int part = 0; part < 2; ++part) {
    positions.middleRows(part * count, count) =
        mesh.positions.rowwise() + Eigen::RowVector3d(0.1, 0.1 + 0.4 * part, 0.1);
    triangles.middleRows(part * mesh.triangles.rows(), mesh.triangles.rows()) =
        mesh.triangles.array() + int(part * count);
  }
  body.surface_rest = positions;
  body.surface.hex.resize(2 * count);
  body.surface.weights.resize(2 * count, 8);
  for (Eigen::Index p = 0; p < 2 * count; ++p) {
    const Vector3d scaled = positions.row(p).transpose() / cell;
    Vector3i at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = std::min(int(scaled[axis] + 1e-9), axis == 1 && p >= count ? 5 : 1);
    for (Eigen::Index e = 0; e < body.lattice.num_hexes(); ++e)
      if (body.lattice.cells.row(e).transpose() == at) body.surface.hex[p] = int(e);
    body.surface.weights.row(p) = shape_functions(2 * (scaled - at.cast<double>()) - Vector3d::Ones()).transpose();
  }
  body.rest_surface = std::make_shared<const RestSurface>(make_rest_surface(positions, triangles));
  body.contact = GENERATE(ContactWith::all, ContactWith::others);
  const Model model = make_model({body}, {test::make_ground(0.5)});
  int within = 0;
  State state = rest_state(model);
  test::simulate(model, StepOptions(), 60, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    within = std::max(within, report.contacts_within);
  });
  const bool touches = body.contact == ContactWith::all;
  CHECK((within > 0) == touches);
  double upper = 0;  // mean height of the nodes of the upper block
  for (int node = 0; node < model.num_nodes(); ++node)
    if (model.rest_positions(node, 1) > 0.3) upper += state.positions(node, 1) / 27;
  CHECK(upper == Approx(touches ? 0.29 : 0.1).margin(0.02));
}

TEST_CASE("contact forces of two bodies have neither sum nor torque") {
  Body left = touchable_block("left", {2, 2, 2}, {0, 0, 0}, 0.1);
  Body right = touchable_block("right", {3, 3, 3}, {0.19, 0.03, 0.02}, 0.08);
  const Model model = make_model({left, right}, {});
  test::Random random(4);
  Points positions = model.rest_positions;
  for (double& value : positions.reshaped()) value += random.uniform(-0.005, 0.005);
  const ContactGeometry geometry = make_contact_geometry(model);
  const ContactStep step = begin_contact_step(model, geometry, positions, positions, 0, 0.01, 9.81);
  std::vector<Contact> contacts;
  REQUIRE(add_contacts(step, LastApart(positions), positions, 0, contacts) > 3);
  for (const Contact& contact : contacts) {
    CHECK(contact.normal.norm() == Approx(1));
    CHECK(contact_position(model, positions, contact).norm() < 1e-12);  // both places are one
    VectorXd nodal = VectorXd::Zero(3 * model.num_nodes());
    const Vector3d force(1, -2, 3);
    spread(model, contact, force, nodal);
    Vector3d sum = Vector3d::Zero(), torque = Vector3d::Zero();
    for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
      const Vector3d at = positions.row(node).transpose(), f = nodal.segment<3>(3 * node);
      sum += f;
      torque += at.cross(f);
    }
    CHECK(sum.norm() < 1e-10 * force.norm());
    CHECK(torque.norm() < 1e-10 * force.norm());
  }
}

TEST_CASE("a gap changes as its supports say, with second order where it is zero") {
  Body left = touchable_block("left", {2, 2, 2}, {0, 0, 0}, 0.1);
  Body right = touchable_block("right", {3, 3, 3}, {0.2, 0.03, 0.02}, 0.08);
  const Model model = make_model({left, right}, {});
  test::Random random(5);
  const ContactGeometry geometry = make_contact_geometry(model);
  Points positions = model.rest_positions, motion = Points::Zero(model.num_nodes(), 3);
  for (double& value : motion.reshaped()) value = random.uniform(-1, 1);
  positions.topRows(27).col(0).array() += 1e-12;  // in touch
  const ContactStep step = begin_contact_step(model, geometry, positions, positions, 0, 0.01, 9.81);
  std::vector<Contact> contacts;
  add_contacts(step, LastApart(positions), positions, 0, contacts);
  int measured = 0;
  for (const Contact& contact : contacts) {
    const Vector3d place = embedded_position(model, positions, contact.support);
    if ((place - Vector3d(place.x(), 0.1, 0.1)).cwiseAbs().maxCoeff() > 0.05) continue;  // ridges
    ++measured;
    const double slope = contact.normal.dot(contact_motion(model, contact, motion.reshaped<Eigen::RowMajor>()));
    const auto error = [&](double h) {
      std::vector<Contact> moved{contact};
      place_surface_contacts(step, LastApart(positions), positions + h * motion, moved);
      return std::abs((moved[0].gap - contact.gap) / h - slope);
    };
    CHECK(error(1e-4) < 0.05);
    CHECK(error(1e-5) < 0.15 * error(1e-4) + 1e-6);
  }
  CHECK(measured > 0);
}

TEST_CASE("a ridge that passes a vertex by a hair does not meet it, one that cuts deep does") {
  const double cell = 0.1;
  const Model model = make_model(
      {touchable_block("slider", {2, 2, 2}, {0, 0, 0}, cell), touchable_block("post", {1, 1, 1}, {1, 0, 0}, cell)}, {});
  const int post_hex = model.bodies[1].first_hex;
  const Support vertex{post_hex, Vector8d::Unit(7)};
  const auto with_vertex_at = [&](const Vector3d& place) {
    Points positions = model.rest_positions;
    const Vector3d by = place - embedded_position(model, positions, vertex);
    for (int node = model.bodies[1].first_node; node < int(model.num_nodes()); ++node)
      positions.row(node) += by.transpose();
    return positions;
  };
  const auto touch = [&](const Vector3d& from, const Vector3d& to) {
    HeldVertex held;
    const Points apart = with_vertex_at(from), positions = with_vertex_at(to);
    const int hex = (to.x() > cell ? 4 : 0) + (to.y() > cell ? 2 : 0);  // nearest to it
    REQUIRE(hold(model, apart, vertex, to, hex_maps(model, positions, hex), around_hex, held));
    return measure(model, held, {});
  };
  // ahead of the front and above the sole, then behind the one and below the other
  CHECK(touch({0.205, 6e-5, 0.05}, {0.175, -5e-5, 0.05}).gap > 0);
  // in by the sole, out by the back
  CHECK(touch({0.02, -1e-7, 0.05}, {-0.01, 3e-6, 0.05}).gap > 0);
  // as the first, but through the middle of the front
  const Touch deep = touch({0.205, 0.02, 0.05}, {0.175, -5e-5, 0.05});
  CHECK(deep.gap == Approx(-0.025).epsilon(0.01));
  CHECK(deep.normal.x() == Approx(1).epsilon(1e-3));
  // in by the sole, out by the top
  CHECK(touch({0.05, -0.01, 0.05}, {0.05, 0.21, 0.05}).gap == Approx(-0.21).epsilon(1e-6));
}

TEST_CASE("a fast ball does not pass through a sheet one hex thick") {
  Body sheet = touchable_block("sheet", {9, 1, 9}, {-0.225, 0, -0.225}, 0.05, 2);
  for (int node = 0; node < int(sheet.lattice.num_nodes()); ++node)
    if (std::abs(sheet.lattice.rest_positions(node, 0)) > 0.2) sheet.fixed_nodes.push_back(node);
  sheet.name = "sheet";
  sheet.material.young = 2e6;
  Body ball = touchable_block("ball", {2, 2, 2}, {-0.05, 0.2, -0.05}, 0.05, 4);
  const double speed = GENERATE(10, 30);  // [m/s] 3.3 and 10 cells a step
  CAPTURE(speed);
  ball.velocity = {0, -speed, 0};
  const Model model = make_model({sheet, ball}, {});
  State state = rest_state(model);
  int substeps = 0;
  test::simulate(model, StepOptions(), 30, state, [&](const StepReport& report, const State& now) {
    CHECK(report.status == StepStatus::converged);
    substeps = std::max(substeps, report.substeps);
    CHECK(report.max_penetration < 2e-2 * 0.05);
    CHECK(highest_of(model, now, 1) > lowest_of(model, now, 0));
  });
  CHECK((substeps > 1) == (speed > 20));
  CHECK(lowest_of(model, state, 1) > -0.3);
}

TEST_CASE("bodies that touch give the same bytes for any number of threads, and light ones rest on heavy ones") {
  Body low = touchable_block("low", {3, 2, 3}, {0, 0.0, 0}, 0.1);
  Body high = touchable_block("high", {2, 2, 2}, {0.05, 0.205, 0.05}, 0.1);
  high.material.density = 5;  // a hundredth
  const Model model = make_model({low, high}, {test::make_ground(0.5)});
  std::vector<State> ends;
  for (const std::size_t threads : {1, 2, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    State state = rest_state(model);
    test::simulate(model, StepOptions(), 40, state, [&](const StepReport& report, const State&) {
      CHECK(report.status == StepStatus::converged);
      CHECK(report.max_penetration < 2e-3 * 0.1);
    });
    ends.push_back(state);
  }
  for (const State& end : ends) {
    CHECK(end.positions == ends[0].positions);
    CHECK(end.velocities == ends[0].velocities);
  }
  CHECK(lowest_of(model, ends[0], 1) > 0.19);
}

TEST_CASE("a body's factor is kept while it hardly moves, and not once contacts have joined its matrix") {
  const BegunStep begun(make_model(
      {touchable_block("low", {2, 1, 2}, {0, 0, 0}, 0.1), touchable_block("high", {2, 1, 2}, {0, 0.3, 0}, 0.1)},
      {test::make_ground(0.5)}));
  const Model& model = begun.model;
  const StepProblem& problem = begun.problem;
  Workspace workspace(model);
  Iterate iterate = predict(problem, begun.state);
  evaluate(problem, iterate.positions, iterate.evaluation);
  Linearisation at{limit_terms(problem, iterate, 1e4), {}};
  const auto factor = [&] { return factorize(problem, at, iterate, workspace.data()); };
  CHECK(factor() == 1);
  CHECK(factor() == 0);
  iterate.positions.array() += 1e-5;  // a ten thousandth of a cell
  CHECK(factor() == 0);
  iterate.positions.row(0).array() += 1e-3;
  CHECK(factor() == 1);
  CHECK(factor() == 0);
  iterate.contacts = {make_contact(model, {ContactKind::vertex, 0}, 0, surface_hex(model, 0))};
  at.contacts = {ContactTerms{.energy = 0, .force = Vector3d::Zero(), .stiffness = 1e4 * Matrix3d::Identity()}};
  CHECK(factor() == 1);
  at.contacts.clear();
  CHECK(factor() == 1);
}
