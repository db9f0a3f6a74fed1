// Contacts whose normals turn to and fro keep a plane, so that steps around an edge end.
#include <algorithm>
#include <utility>
#include <vector>

#include "core/contact/surface_contact.h"
#include "core/problem/iterate.h"
#include "core/problem/step_contacts.h"
#include "tests/support/begun_step.h"
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
    REQUIRE(add_surface_contacts(step, LastApart(model.rest_positions), near, 0, contacts) > 0);
    contacts.resize(1);
  }
  Points raised(double by) const {
    Points positions = model.rest_positions;
    positions.bottomRows(27).col(1).array() += by;
    return positions;
  }
  void place(const Points& positions) {
    place_surface_contacts(step, LastApart(model.rest_positions), positions, contacts);
  }
  // of the contact, found anew, that has kept this plane while the block rose so far from where it was placed [m]
  Vector3d normal_after(const Vector3d& kept, double gap, double rise) {
    contacts.clear();
    REQUIRE(add_surface_contacts(step, LastApart(model.rest_positions), near, 0, contacts) > 0);
    contacts.resize(1);
    Contact& contact = contacts.front();
    contact.position += rise * kept.dot(contact.normal) * kept;
    contact.normal = kept;
    contact.gap = gap;
    contact.turns_back = 3;
    place(raised(rise));
    return contacts.front().normal;
  }
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

TEST_CASE("a contact keeps its plane from the second time on that its normal turns back") {
  SunkBlock block;
  Contact& contact = block.contacts.front();
  const Vector3d up = contact.normal;
  for (const double side : {0.03, -0.03, 0.03}) {  // the first turn is no turn back
    CHECK(!keeps_plane(contact));
    contact.normal = (up + Vector3d(side, 0, 0)).normalized();
    block.place(block.near);
  }
  CHECK(keeps_plane(contact));
}

TEST_CASE("a kept plane that faces away from the side by which the vertex is inside gives way to that side's") {
  SunkBlock block;
  const Vector3d up = block.contacts.front().normal;
  const double deep = -3 * tolerance, little = -0.2 * tolerance;
  const Vector3d across = Vector3d(0.9, 0.1, 0).normalized();
  CHECK((block.normal_after(-up, 0, deep) - up).norm() < 1e-12);
  CHECK(block.normal_after(across, 0, deep) == across);          // of a ridge or a groove
  CHECK(block.normal_after(-up, 0, little) == -up);              // at the surface, as at the edge of a blade
  CHECK(block.normal_after(-up, -10 * tolerance, deep) == -up);  // it is farther behind that one
  CHECK(block.normal_after(-up, 10 * tolerance, deep) == -up);   // of the other wall of a slot
}

TEST_CASE("a vertex that is outside lets go of a kept plane that would push it in") {
  SunkBlock block;
  const Vector3d up = block.contacts.front().normal;
  const double out = 3 * tolerance;
  const Vector3d behind = (Vector3d(0.9, 0, 0) - 0.1 * up).normalized(),
                 across = (Vector3d(0.9, 0, 0) + 0.1 * up).normalized();
  CHECK((block.normal_after(behind, -2 * tolerance, out) - up).norm() < 1e-12);
  CHECK(block.normal_after(across, -2 * tolerance, out) == across);               // of a ridge
  CHECK(block.normal_after(behind, -0.5 * tolerance, out) == behind);             // it hardly pushes
  CHECK(block.normal_after(behind, -2 * tolerance, -0.2 * tolerance) == behind);  // the vertex is inside
}

TEST_CASE("of a vertex in a thin part no planes of both its sides are held at once") {
  SunkBlock block;
  const Contact found = block.contacts.front();
  const auto planes_with = [&](const Vector3d& normal, double gap) {
    std::vector<Contact> contacts = {found};
    contacts.front().normal = normal;
    contacts.front().gap = gap;
    contacts.front().turns_back = 3;
    add_surface_contacts(block.step, LastApart(block.model.rest_positions), block.near, 0, contacts);
    return std::count_if(contacts.begin(), contacts.end(),
                         [&](const Contact& contact) { return contact.point == found.point; });
  };
  CHECK(planes_with(Vector3d(1, 0, 0), 0) == 2);           // in a groove
  CHECK(planes_with(-found.normal, 10 * tolerance) == 2);  // in a slot
  CHECK(planes_with(-found.normal, 0) == 1);
}

TEST_CASE("a contact far from the surface is forgotten within a step, unless its normal has turned back") {
  SunkBlock block;
  const test::BegunStep begun(block.model);
  Iterate iterate = predict(begun.problem, begun.state);
  iterate.positions = block.raised(100 * tolerance);
  for (const int turns_back : {0, 1}) {
    iterate.contacts = {block.contacts.front()};
    iterate.contacts.front().gap = 100 * tolerance;
    iterate.contacts.front().turns_back = turns_back;
    find_contacts(begun.problem, false, iterate);
    CHECK(int(iterate.contacts.size()) == turns_back);
  }
}

TEST_CASE(
    "the planes that held a vertex in a step are one contact at the start of the next, which leaves room for others") {
  SunkBlock block;
  State state = rest_state(block.model);
  const Contact& held = block.contacts.front();
  for (const double impulse : {1.0, 2.0, 4.0})
    state.contacts.push_back({held.point, held.obstacle, held.support.hex, held.other.hex, Vector3d(0, impulse, 0)});
  const test::BegunStep begun(block.model, state);
  const std::vector<Contact> contacts = recall_contacts(begun.problem, state, block.near);
  REQUIRE(contacts.size() == 1);
  CHECK(contacts.front().force == Vector3d(0, 7 / begun.problem.h, 0));
}

TEST_CASE(
    "planes of a vertex that have become one are one contact, and the farthest of the most leaves room if it is idle") {
  SunkBlock block;
  Contact up = block.contacts.front(), beside = up, lower = up;
  up.force = Vector3d(0, 1, 0);
  beside.normal = Vector3d(1, 0, 0);
  std::vector<Contact> contacts = {up, beside, up};
  while (contacts.size() <= most_planes) {
    lower.gap -= 0.1 * tolerance;
    contacts.push_back(lower);
  }
  make_room_for_planes(block.model, contacts);
  REQUIRE(contacts.size() == most_planes);
  CHECK(contacts[0].force == Vector3d(0, 2, 0));
  CHECK(contacts[1].normal == beside.normal);
  CHECK(contacts.back().gap == lower.gap);
  for (const double force : {1.0, 0.0}) {
    contacts[1].gap = 2 * tolerance;
    contacts[1].force = Vector3d(force, 0, 0);
    make_room_for_planes(block.model, contacts);
    CHECK(contacts.size() == most_planes - (force > 0 ? 0 : 1));
  }
  CHECK(contacts[1].normal != beside.normal);
}

TEST_CASE(
    "a vertex that has slid around something round is held by the surface there, though planes left behind push") {
  SunkBlock block;
  const Contact found = block.contacts.front();
  std::vector<Contact> contacts;
  for (const double side : {-0.3, -0.28, -0.26}) {
    contacts.push_back(found);
    contacts.back().normal = (found.normal + Vector3d(side, 0, 0)).normalized();
    contacts.back().force = contacts.back().normal;
    contacts.back().gap = 0;
    contacts.back().turns_back = 3;
  }
  add_surface_contacts(block.step, LastApart(block.model.rest_positions), block.near, 0, contacts);
  CHECK(std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    return contact.point == found.point && contact.normal == found.normal && contact.gap == found.gap;
  }));
}
