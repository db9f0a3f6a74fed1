// Contact between unequal bodies, of crushed ones, across interruptions, by both linear solvers; and its search against one
// that looks at everything.
#include <cmath>
#include <optional>

#include "core/contact/contact_support.h"
#include "core/contact/material_point.h"
#include "core/contact/surface_contact.h"
#include "core/contact/vertex_clusters.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

struct Collision {
  int iterations = 0, not_converged = 0;
  double deepest = 0;  // [cells of the finer body]
  State end;
};

// the block `high` falls onto `low`
Collision collide(const Body& low, const Body& high, LinearSolver linear, int steps) {
  const Model model = make_model({low, high}, {make_ground(0.5)});
  StepOptions options;
  options.solver.linear = linear;
  Collision collision{.end = rest_state(model)};
  double cell = model.bodies[0].cell_size;
  for (const Model::BodyRange& body : model.bodies) cell = std::min(cell, body.cell_size);
  simulate(model, options, steps, collision.end, [&](const StepReport& report, const State&) {
    collision.iterations += report.sqp_iterations;
    if (report.status != StepStatus::converged) ++collision.not_converged;
    collision.deepest = std::max(collision.deepest, report.max_penetration / cell);
  });
  return collision;
}

// gap of the deepest vertex of a hex in a body, by a look at every vertex and every hex; none: none is inside
std::optional<double> deepest_by_hand(const Model& model, const Points& positions, int hex, int body) {
  const Model::BodyRange& range = model.bodies[body];
  std::optional<double> deepest;
  for (Eigen::Index point = 0; point < model.num_points(); ++point) {
    if (surface_hex(model, point) != hex) continue;
    const Vector3d position = embedded_position(model, positions, {hex, surface_weights(model, point)});
    for (int other = range.first_hex; other < range.first_hex + range.num_hexes; ++other) {
      MaterialPoint material;
      if (!find_material(hex_maps(model, positions, other), position, within_hex, material)) continue;
      const SurfaceHit hit = nearest_point(*range.rest_surface, range.rest_pose.local(material.rest), 1e9);
      const double gap = hit.distance / (material.F_inverse.transpose() * hit.normal).norm();
      if (gap < 0 && (!deepest || gap < *deepest)) deepest = gap;
      break;
    }
  }
  return deepest;
}

}  // namespace

TEST_CASE("bodies a thousand times heavier, stiffer, or eight times finer collide like equal ones") {
  const LinearSolver linear = GENERATE(LinearSolver::direct, LinearSolver::multigrid);
  CAPTURE(int(linear));
  const Body low = touchable_block("low", {4, 2, 4}, {0, 0, 0}, 0.1);
  const Body equal = touchable_block("high", {2, 2, 2}, {0.1, 0.22, 0.1}, 0.1);
  const Collision of_equals = collide(low, equal, linear, 30);
  CHECK(of_equals.not_converged == 0);
  Body high = equal, below = low;
  SECTION("light on heavy") {
    high.material.density = below.material.density.at(0) / 1000;
  }
  SECTION("soft on stiff") {
    below.material.young = 5e7;
    high.material.young = 5e4;
  }
  SECTION("fine on coarse") {
    below = touchable_block("low", {1, 1, 1}, {0, 0, 0}, 0.4);
    high = touchable_block("high", {4, 4, 4}, {0.1, 0.42, 0.1}, 0.05);
  }
  SECTION("coarse on fine") {
    below = touchable_block("low", {8, 4, 8}, {0, 0, 0}, 0.05);
    high = touchable_block("high", {1, 1, 1}, {0, 0.22, 0}, 0.4, 16);
  }
  const Collision collision = collide(below, high, linear, 30);
  CHECK(collision.not_converged == 0);
  CHECK(collision.iterations <= 3 * of_equals.iterations);
  CHECK(collision.deepest < 2e-3);
}

TEST_CASE("what touches is found as by a search that looks at everything") {
  const Body left = touchable_block("left", {3, 3, 3}, {0, 0, 0}, 0.1);
  const Body right = touchable_ball("right", 4, {0.4, 0.15, 0.13}, 0.13);
  const Model model = make_model({left, right}, {});
  Random random(9);
  Points positions = model.rest_positions;
  for (double& value : positions.reshaped()) value += random.uniform(-0.008, 0.008);
  const ContactGeometry geometry = make_contact_geometry(model);
  const double time_step = 1e3;  // [s] all depths may be mended in it
  const ContactStep step = begin_contact_step(model, geometry, positions, positions, 0, time_step, 0);
  const std::vector<Contact> found = surface_candidates(step, LastApart(positions), positions, 0);
  int expected = 0;
  for (int hex = 0; hex < model.num_hexes(); ++hex) {
    const int other = 1 - model.hex_body[hex];
    const std::optional<double> deepest = deepest_by_hand(model, positions, hex, other);
    const auto contact =
        std::find_if(found.begin(), found.end(), [&](const Contact& c) { return c.support.hex == hex; });
    CAPTURE(hex, deepest.value_or(1));
    REQUIRE((contact != found.end()) == deepest.has_value());
    if (!deepest) continue;
    ++expected;
    CHECK(contact->gap == Approx(*deepest).epsilon(1e-9));
  }
  CHECK(expected > 10);
  CHECK(int(found.size()) == expected);
}

TEST_CASE("clusters hold each vertex once, and their spheres where it is") {
  const Model model = make_model({touchable_ball("ball", 3, {0, 0, 0}, 0.3)}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  const VertexClusters& clusters = geometry.clusters;
  Random random(3);
  Points positions = model.rest_positions;
  for (double& value : positions.reshaped()) value += random.uniform(-0.05, 0.05);
  std::vector<int> times(std::size_t(model.num_points()), 0);
  for (int hex = 0; hex < model.num_hexes(); ++hex)
    for (int c = clusters.hex_starts[hex]; c < clusters.hex_starts[hex + 1]; ++c) {
      const Matrix8x3d nodes = hex_nodes(model, positions, hex);
      const ClusterSphere sphere = sphere_around(clusters.all[c], nodes, longest_half_edges(nodes));
      CHECK(clusters.all[c].count <= 16);
      for (int k = clusters.all[c].first; k < clusters.all[c].first + clusters.all[c].count; ++k) {
        const int point = clusters.points[k];
        ++times[std::size_t(point)];
        CHECK(surface_hex(model, point) == hex);
        const Vector3d place = embedded_position(model, positions, {hex, surface_weights(model, point)});
        CHECK((place - sphere.centre).norm() <= sphere.radius * (1 + 1e-9));
      }
    }
  for (const int count : times) CHECK(count == 1);
}

TEST_CASE("a run that is interrupted while bodies touch goes on to the same bytes") {
  Body low = touchable_block("low", {3, 2, 3}, {0, 0, 0}, 0.1);
  Body high = touchable_ball("high", 3, {0.15, 0.33, 0.15}, 0.12);
  high.velocity = {0.5, -2, 0};
  const Model model = make_model({low, high}, {make_ground(0.5)});
  State whole = rest_state(model);
  State middle;
  int done = 0;
  simulate(model, StepOptions(), 24, whole, [&](const StepReport& report, const State& now) {
    if (++done != 12) return;
    CHECK(report.contacts_between > 0);
    middle = now;
  });
  simulate(model, StepOptions(), 12, middle, [](const StepReport&, const State&) {});
  CHECK(middle.positions == whole.positions);
  CHECK(middle.velocities == whole.velocities);
  CHECK(middle.limit_multipliers == whole.limit_multipliers);
}

TEST_CASE("the factor and the multigrids end a step with contact between bodies alike") {
  Body low = touchable_block("low", {3, 2, 3}, {0, 0, 0}, 0.1);
  Body high = touchable_block("high", {2, 2, 2}, {0.05, 0.205, 0.05}, 0.1);
  high.velocity = {0.3, -1, 0};
  for (Body* body : {&low, &high}) body->limit = {.kind = LimitKind::hard, .value = 0.1};
  const Model model = make_model({low, high}, {make_ground(0.5)});
  State start = rest_state(model);
  simulate(model, StepOptions(), 3, start, [](const StepReport&, const State&) {});
  std::vector<State> ends;
  for (const LinearSolver linear : {LinearSolver::direct, LinearSolver::multigrid}) {
    StepOptions options;
    options.solver.linear = linear;
    options.solver.tolerance = 1e-6;
    ends.push_back(start);
    simulate(model, options, 1, ends.back(), [&](const StepReport& report, const State&) {
      CHECK(report.status == StepStatus::converged);
      CHECK(report.contacts_between > 0);
    });
  }
  CHECK((ends[0].positions - ends[1].positions).rowwise().norm().maxCoeff() < 1e-4 * 0.1);
}

TEST_CASE("a crushed pile with inverted hexes recovers") {
  std::vector<Body> bodies;
  for (int i = 0; i < 3; ++i)
    bodies.push_back(touchable_block("b" + std::to_string(i), {2, 2, 2}, {0.03 * i, 0.22 * i + 0.01, 0.02 * i}, 0.1));
  const Model model = make_model(bodies, {make_ground(0.5)});
  State state = rest_state(model);
  Random random(11);
  for (int node = 0; node < model.num_nodes(); ++node) {  // each body crumpled about its own centre
    const Model::BodyRange& body = model.bodies[node < 27 ? 0 : node < 54 ? 1 : 2];
    const Eigen::RowVector3d centre = model.rest_positions.middleRows(body.first_node, body.num_nodes).colwise().mean();
    for (int axis = 0; axis < 3; ++axis)
      state.positions(node, axis) =
          centre[axis] + 0.6 * (state.positions(node, axis) - centre[axis]) + random.uniform(-0.07, 0.07);
  }
  int inverted = 0;
  for (int e = 0; e < model.num_hexes(); ++e) {
    const Matrix3d F = hex_nodes(model, state.positions, e).transpose() * shape_gradients(Vector3d::Zero());
    inverted += F.determinant() < 0;
  }
  REQUIRE(inverted > 0);
  StepOptions options;
  StepReport last;
  simulate(model, options, 150, state, [&](const StepReport& report, const State&) { last = report; });
  CHECK(last.status == StepStatus::converged);
  CHECK(last.max_penetration < 2e-3 * 0.1);
  CHECK(find_overlaps(model, state).empty());
  CHECK(last.elastic_energy < 1);
  for (int body = 0; body < 3; ++body) CHECK(highest_of(model, state, body) - lowest_of(model, state, body) > 0.15);
}
