// Contacts whose normals turn to and fro keep a plane, so that steps around an edge end.
#include "core/contact/surface_contact.h"

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

TEST_CASE("a contact that keeps its plane keeps the plane's gap, unless the surface is elsewhere by half a tolerance") {
  const double cell = 0.1, tolerance = 1e-3 * cell;
  const Model model = make_model(
      {touchable_block("low", {2, 2, 2}, {0, 0, 0}, cell), touchable_block("high", {2, 2, 2}, {0, 0.2, 0}, cell)}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  Points positions = model.rest_positions;
  positions.bottomRows(27).col(1).array() -= 0.2 * tolerance;
  const ContactStep step = begin_contact_step(model, geometry, model.rest_positions, positions, 0, 0.01, 9.81);
  std::vector<Contact> contacts;
  REQUIRE(add_surface_contacts(step, model.rest_positions, positions, 0, contacts) > 0);
  Contact contact = contacts.front();
  const double gap = contact.gap;
  contact.normal = Vector3d(0.05, contact.normal.y(), 0).normalized();  // of a face beside
  contact.turns_back = 3;
  REQUIRE(keeps_plane(contact));
  const auto gap_after = [&](double of_plane) {
    std::vector<Contact> placed{contact};
    placed[0].gap = of_plane;
    place_surface_contacts(step, model.rest_positions, positions, placed);
    CHECK(placed[0].normal == contact.normal);
    return placed[0].gap;
  };
  for (const double off : {-0.4, 0.4}) CHECK(gap_after(gap + off * tolerance) == Approx(gap + off * tolerance));
  for (const double off : {-0.6, 0.6}) CHECK(gap_after(gap + off * tolerance) == gap);
}

TEST_CASE(
    "a contact whose normal turns to and fro keeps its plane, though the vertex is away from the surface in between") {
  const double cell = 0.1, tolerance = 1e-3 * cell;
  const Model model = make_model(
      {touchable_block("low", {2, 2, 2}, {0, 0, 0}, cell), touchable_block("high", {2, 2, 2}, {0, 0.2, 0}, cell)}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  Points near = model.rest_positions, away = model.rest_positions;
  near.bottomRows(27).col(1).array() -= 0.2 * tolerance;
  away.bottomRows(27).col(1).array() += 30 * tolerance;
  const ContactStep step = begin_contact_step(model, geometry, model.rest_positions, near, 0, 0.01, 9.81);
  std::vector<Contact> contacts;
  REQUIRE(add_surface_contacts(step, model.rest_positions, near, 0, contacts) > 0);
  contacts.resize(1);
  Contact& contact = contacts.front();
  const Vector3d up = contact.normal;
  for (int round = 0; round < 5; ++round)  // as if it slid around an edge
    for (const Points* positions : {&near, &away}) {
      contact.normal = (up + Vector3d(positions == &near ? 0.3 : -0.3, 0, 0)).normalized();
      place_surface_contacts(step, model.rest_positions, *positions, contacts);
    }
  CHECK(keeps_plane(contact));
  // away from the surface it goes along with it all the same
  CHECK((contact.normal - up).norm() < 1e-12);
  contact.normal = (up + Vector3d(0.05, 0, 0)).normalized();
  place_surface_contacts(step, model.rest_positions, near, contacts);
  CHECK(contact.normal != up);
}

TEST_CASE("a contact whose normal rests for an iteration between its turns to and fro keeps its plane as well") {
  const double cell = 0.1, tolerance = 1e-3 * cell;
  const Model model = make_model(
      {touchable_block("low", {2, 2, 2}, {0, 0, 0}, cell), touchable_block("high", {2, 2, 2}, {0, 0.2, 0}, cell)}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  Points near = model.rest_positions;
  near.bottomRows(27).col(1).array() -= 0.2 * tolerance;
  const ContactStep step = begin_contact_step(model, geometry, model.rest_positions, near, 0, 0.01, 9.81);
  std::vector<Contact> contacts;
  REQUIRE(add_surface_contacts(step, model.rest_positions, near, 0, contacts) > 0);
  contacts.resize(1);
  const Vector3d up = contacts.front().normal;
  for (int round = 0; round < 5; ++round)
    for (const double side : {0.03, -0.03}) {
      contacts.front().normal = (up + Vector3d(side, 0, 0)).normalized();
      for (int look = 0; look < 2; ++look) place_surface_contacts(step, model.rest_positions, near, contacts);
    }
  CHECK(keeps_plane(contacts.front()));
}
