// What a contact does to the nodes that carry it, and its row in the step's complementarity problem.
#include "core/contact/contact_support.h"

#include "core/problem/step_contacts.h"
#include "tests/support/begun_step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;

namespace {

Contact contact_in(int hex) {
  Contact contact;
  contact.support.hex = hex;
  contact.support.weights = shape_functions({0.3, -0.2, 0.7});
  contact.normal = Vector3d(1, 2, -2) / 3;
  contact.friction = 0.4;
  contact.gap = 0.01;
  contact.obstacle_motion = {0.001, -0.002, 0.003};
  return contact;
}

}  // namespace

TEST_CASE("a contact takes motions from the nodes to which it spreads forces") {
  const Model model = make_model({test::make_block({2, 2, 2}, {0, 0, 0}, 0.1)}, {test::make_ground(0.5)});
  const Contact contact = contact_in(5);
  test::Random random(3);
  VectorXd v(3 * model.num_nodes());
  for (double& value : v) value = random.uniform(-1, 1);
  const Vector3d force = random.vector(2);
  VectorXd push = VectorXd::Zero(v.size());
  spread(model, contact, force, push);
  CHECK(contact_motion(model, contact, v).dot(force) == Approx(v.dot(push)));
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) sum += push.segment<3>(3 * node);
  CHECK((sum - force).norm() < 1e-14);
  CHECK(bodies_of(model, contact).first == 0);
}

TEST_CASE("a contact's row asks for the gap along its motion against the obstacle so far") {
  const test::BegunStep begun(make_model({test::make_block({2, 2, 2}, {0, 0, 0}, 0.1)}, {test::make_ground(0.5)}));
  const Contact contact = contact_in(2);
  const Vector3d moved(0.02, 0.01, -0.03), relative = moved - contact.obstacle_motion;
  const Points positions = begun.state.positions.rowwise() + moved.transpose();
  const ContactRows rows = contact_rows(begun.problem, positions, {contact, contact});
  REQUIRE(rows.rows.size() == 2);
  for (int i = 0; i < 2; ++i) {
    CHECK((rows.motions.segment<3>(3 * i) - relative).norm() < 1e-15);
    CHECK(rows.rows[i].bias + contact.normal.dot(relative) == Approx(contact.gap));
    CHECK(rows.rows[i].friction == 0.4);
    CHECK(rows.rows[i].normal == contact.normal);
  }
}
