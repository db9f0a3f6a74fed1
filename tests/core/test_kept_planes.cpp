// Contacts whose normals turn to and fro keep a plane, so that steps around an edge end.
#include "core/contact/surface_contact.h"

#include <utility>

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double cell = 0.1, tolerance = 1e-3 * cell;

// a block on another one, which has sunk in by a fifth of a tolerance, and their first contact there
struct SunkBlock {
  Model model = make_model(
      {touchable_block("low", {2, 2, 2}, {0, 0, 0}, cell), touchable_block("high", {2, 2, 2}, {0, 0.2, 0}, cell)}, {});
  ContactGeometry geometry = make_contact_geometry(model);
  Points near = raised(-0.2 * tolerance);
  ContactStep step = begin_contact_step(model, geometry, model.rest_positions, near, 0, 0.01, 9.81);
  std::vector<Contact> contacts;

  SunkBlock() {
    REQUIRE(add_surface_contacts(step, model.rest_positions, near, 0, contacts) > 0);
    contacts.resize(1);
  }
  Points raised(double by) const {
    Points positions = model.rest_positions;
    positions.bottomRows(27).col(1).array() += by;
    return positions;
  }
  void place(const Points& positions) { place_surface_contacts(step, model.rest_positions, positions, contacts); }
};

}  // namespace

TEST_CASE("a contact that keeps its plane keeps the plane's gap, unless the surface is elsewhere by half a tolerance") {
  SunkBlock block;
  Contact contact = block.contacts.front();
  const double gap = contact.gap;
  contact.normal = Vector3d(0.05, contact.normal.y(), 0).normalized();  // of a face beside
  contact.turns_back = 3;
  REQUIRE(keeps_plane(contact));
  const auto gap_after = [&](double of_plane) {
    block.contacts = {contact};
    block.contacts[0].gap = of_plane;
    block.place(block.near);
    CHECK(block.contacts[0].normal == contact.normal);
    return block.contacts[0].gap;
  };
  for (const double off : {-0.4, 0.4}) CHECK(gap_after(gap + off * tolerance) == Approx(gap + off * tolerance));
  for (const double off : {-0.6, 0.6}) CHECK(gap_after(gap + off * tolerance) == gap);
}

TEST_CASE(
    "a contact whose normal turns to and fro keeps its plane, though the vertex is away from the surface in between") {
  SunkBlock block;
  const Points away = block.raised(30 * tolerance);
  Contact& contact = block.contacts.front();
  const Vector3d up = contact.normal;
  for (int round = 0; round < 5; ++round)  // as if it slid around an edge
    for (const Points* positions : {&std::as_const(block.near), &away}) {
      contact.normal = (up + Vector3d(positions == &away ? -0.3 : 0.3, 0, 0)).normalized();
      block.place(*positions);
    }
  CHECK(keeps_plane(contact));
  // away from the surface it goes along with it all the same
  CHECK((contact.normal - up).norm() < 1e-12);
  contact.normal = (up + Vector3d(0.05, 0, 0)).normalized();
  block.place(block.near);
  CHECK(contact.normal != up);
}

TEST_CASE("a contact whose normal rests for an iteration between its turns to and fro keeps its plane as well") {
  SunkBlock block;
  Contact& contact = block.contacts.front();
  const Vector3d up = contact.normal;
  for (int round = 0; round < 5; ++round)
    for (const double side : {0.03, -0.03}) {
      contact.normal = (up + Vector3d(side, 0, 0)).normalized();
      for (int look = 0; look < 2; ++look) block.place(block.near);
    }
  CHECK(keeps_plane(contact));
}
