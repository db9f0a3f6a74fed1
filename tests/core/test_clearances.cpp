// What a search for contacts keeps from one look to the next, and what a part of a model takes over from the whole.
#include "core/contact/clearances.h"

#include <algorithm>
#include <cmath>

#include "core/contact/contact_support.h"
#include "core/contact/surface_contact.h"
#include "core/contact/surface_overlap.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

ContactStep fresh_step(const Model& model, const ContactGeometry& geometry, const Points& start,
                       const Points& expected) {
  return begin_contact_step(model, geometry, start, expected, 0, 1e3, 0);
}

bool are_equal(const std::vector<Contact>& a, const std::vector<Contact>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Contact& one, const Contact& other) {
    return one.point == other.point && one.other.hex == other.other.hex && one.gap == other.gap &&
           one.normal == other.normal && one.friction == other.friction;
  });
}

// a ball above a block of cells of 0.1 m, which ends at 0.3 m
Model ball_above_block(double height) {
  return make_model(
      {touchable_block("low", {3, 3, 3}, {0, 0, 0}, 0.1), touchable_ball("high", 4, {0.15, height, 0.15}, 0.13)}, {});
}

// A bar of 1 m along x, 10 cm thick, bent to a U whose walls are `gap` [m] apart.
Points bent_to_u(const Points& bar, double gap) {
  constexpr double thickness = 0.1, straight = 0.3;
  const double radius = 0.5 * (gap + thickness), arc = std::acos(-1.0) * radius;
  Points bent = bar;
  for (Eigen::Index i = 0; i < bar.rows(); ++i) {
    const double along = bar(i, 0), inwards = bar(i, 1) - 0.5 * thickness;
    const double turn = std::clamp((along - straight) / radius, 0.0, std::acos(-1.0));
    const double beyond = along < straight ? straight - along : std::max(0.0, along - straight - arc);
    const double reach = radius - inwards;
    bent.row(i) << -reach * std::cos(turn), beyond - reach * std::sin(turn), bar(i, 2);
  }
  return bent;
}

}  // namespace

TEST_CASE("a search that remembers finds what one finds that begins anew, wherever bodies go") {
  const Body left = touchable_block("left", {3, 3, 3}, {0, 0, 0}, 0.1);
  const Body right = touchable_ball("right", 4, {0.45, 0.15, 0.13}, 0.13);
  const Body far = touchable_block("far", {2, 2, 2}, {0.05, 0.35, 0.05}, 0.1);
  const Model model = make_model({left, right, far}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  const Points rest = model.rest_positions;
  const ContactStep remembering = fresh_step(model, geometry, rest, rest);
  const double stride = GENERATE(1e-4, 2e-3, 2e-2);  // [m] a look; cells are 0.1 m
  CAPTURE(stride);
  Random random(17);
  Points positions = rest;
  const Model::BodyRange &ball = model.bodies[1], &block = model.bodies[2];
  int most = 0;
  for (int look = 0; look < 25; ++look) {
    for (double& value : positions.reshaped()) value += random.uniform(-0.1, 0.1) * stride;
    const double sign = look % 8 < 5 ? 1 : -1;  // it goes in, and sometimes back
    positions.middleRows(ball.first_node, ball.num_nodes).col(0).array() -= sign * stride;
    positions.middleRows(block.first_node, block.num_nodes).col(1).array() -= sign * stride;
    const ContactStep anew = fresh_step(model, geometry, rest, positions);
    const std::vector<Contact> found = surface_candidates(remembering, LastApart(rest), positions, 0);
    CAPTURE(look);
    REQUIRE(are_equal(found, surface_candidates(anew, LastApart(rest), positions, 0)));
    most = std::max(most, int(found.size()));
  }
  if (stride > 1e-2) CHECK(most > 5);
}

TEST_CASE("a step that goes on from what the last one remembers finds what one finds that begins anew") {
  const Model model = ball_above_block(0.445);
  const ContactGeometry geometry = make_contact_geometry(model);
  const double stride = GENERATE(1e-4, 3e-3);  // [m] a look; cells are 0.1 m
  CAPTURE(stride);
  Random random(3);
  Points start = model.rest_positions;
  std::shared_ptr<Clearances> known;
  const auto measured = std::make_shared<Clearances>();
  int found_in_all = 0;
  for (int step = 0; step < 12; ++step) {
    const double fall = step < 8 ? 8e-3 : -5e-3;
    Points expected = start;
    expected.middleRows(model.bodies[1].first_node, model.bodies[1].num_nodes).col(1).array() -= fall;
    const ContactStep going_on = begin_contact_step(model, geometry, start, expected, 0, 1e3, 0, known);
    known = going_on.clearances;
    Points positions = expected;
    for (int look = 0; look < 4; ++look) {
      for (double& value : positions.reshaped()) value += random.uniform(-1, 1) * stride;
      const std::vector<Contact> found = surface_candidates(going_on, LastApart(start), positions, 0);
      CAPTURE(step, look);
      REQUIRE(are_equal(
          found, surface_candidates(fresh_step(model, geometry, start, positions), LastApart(start), positions, 0)));
      REQUIRE(max_surface_penetration(model, geometry, positions) ==
              max_surface_penetration(model, geometry, positions, measured));
      found_in_all += int(found.size());
    }
    start = positions;
  }
  CHECK(found_in_all > 5);
}

TEST_CASE("looks at what has hardly moved are few") {
  const Model model = ball_above_block(0.435);
  const ContactGeometry geometry = make_contact_geometry(model);
  Points positions = model.rest_positions;
  const ContactStep step = fresh_step(model, geometry, positions, positions);
  surface_candidates(step, LastApart(model.rest_positions), positions, 0);
  positions.col(1).array() += 1e-6;
  surface_candidates(step, LastApart(model.rest_positions), positions, 0);
  int near = 0, all = 0;
  for (const Clearances::OfEncounter& of : step.clearances->of_encounters)
    for (const double until : of.until) {
      ++all;
      near += !(until > of.way);
    }
  REQUIRE(all > 100);
  CHECK(near * 20 < all);
}

TEST_CASE("vertices far from what they could touch are looked at anew at another part of that body") {
  constexpr double gap = 0.137;  // [m] between the walls of a U
  const Model model = make_model(
      {touchable_block("bar", {10, 1, 1}, {0, 0, 0}, 0.1), touchable_ball("ball", 1, {2, 0.15, 0.05}, 0.05)}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  const Model::BodyRange &bar = model.bodies[0], &ball = model.bodies[1];
  Points start = model.rest_positions;
  start.topRows(bar.num_nodes) = bent_to_u(start.topRows(bar.num_nodes), gap);
  start.middleRows(ball.first_node, ball.num_nodes).rowwise() += Eigen::RowVector3d(-0.5 * gap + 0.055 - 2, 0, 0);
  const ContactStep remembering = fresh_step(model, geometry, start, start);
  REQUIRE(surface_candidates(remembering, LastApart(start), start, 0).empty());
  Points positions = start;
  positions.middleRows(ball.first_node, ball.num_nodes).col(0).array() += 0.034;  // 2 mm into the other wall
  const std::vector<Contact> found = surface_candidates(remembering, LastApart(start), positions, 0);
  CHECK(!found.empty());
  CHECK(are_equal(found,
                  surface_candidates(fresh_step(model, geometry, start, positions), LastApart(start), positions, 0)));
}

TEST_CASE("what is known of vertices stays when bodies leave the places where they were expected") {
  const Model model = ball_above_block(0.435);
  const ContactGeometry geometry = make_contact_geometry(model);
  Points positions = model.rest_positions;
  const ContactStep step = fresh_step(model, geometry, positions, positions);
  surface_candidates(step, LastApart(model.rest_positions), positions, 0);
  Clearances& clearances = *step.clearances;
  const auto num_known = [&] {
    return std::count_if(clearances.of_encounters.begin(), clearances.of_encounters.end(),
                         [](const Clearances::OfEncounter& of) { return !of.until.empty(); });
  };
  const auto before = num_known();
  REQUIRE(before > 10);
  positions.col(0).array() += 0.05;  // half a cell, both
  complete(model, geometry.touchable, geometry.hex_starts, positions, 0.15, clearances);
  CHECK(clearances.encounters.expected == positions);
  CHECK(num_known() == before);
  positions.middleRows(model.bodies[1].first_node, model.bodies[1].num_nodes).col(0).array() += 0.05;  // one
  complete(model, geometry.touchable, geometry.hex_starts, positions, 0.15, clearances);
  CHECK(2 * num_known() > before);
  CHECK(std::any_of(clearances.of_encounters.begin(), clearances.of_encounters.end(),
                    [](const Clearances::OfEncounter& of) { return !of.unseen.empty(); }));
}

TEST_CASE("a part of a model has the contact geometry that it would make by itself") {
  const Model model =
      make_model({touchable_block("a", {2, 2, 2}, {0, 0, 0}, 0.1), touchable_ball("b", 3, {0.6, 0.15, 0.13}, 0.13),
                  touchable_block("c", {3, 1, 2}, {1, 0, 0}, 0.1)},
                 {make_ground(0.5)});
  const std::vector<int> bodies{1, 2};
  const Model part = part_of(model, bodies);
  const ContactGeometry taken = part_of(model, make_contact_geometry(model), part, bodies),
                        made = make_contact_geometry(part);
  CHECK(taken.hex_starts == made.hex_starts);
  CHECK(taken.hex_points == made.hex_points);
  CHECK(taken.touchable.surfaces == made.touchable.surfaces);
  CHECK(taken.clusters.hex_starts == made.clusters.hex_starts);
  CHECK(taken.clusters.points == made.clusters.points);
  REQUIRE(taken.clusters.all.size() == made.clusters.all.size());
  for (std::size_t c = 0; c < made.clusters.all.size(); ++c) {
    CHECK(taken.clusters.all[c].first == made.clusters.all[c].first);
    CHECK(taken.clusters.all[c].centre == made.clusters.all[c].centre);
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    REQUIRE(taken.touchable.trees[b].nodes.size() == made.touchable.trees[b].nodes.size());
    for (std::size_t n = 0; n < made.touchable.trees[b].nodes.size(); ++n)
      CHECK(taken.touchable.trees[b].nodes[n].hex == made.touchable.trees[b].nodes[n].hex);
  }
}
