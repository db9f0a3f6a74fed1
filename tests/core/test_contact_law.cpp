// The terms that contacts add to the augmented Lagrangian: derivatives in all three states, and what a force turns
// into.
#include <Eigen/Geometry>

#include "core/contact/contact_law.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

constexpr double penalty = 250;

Contact contact_at(const Vector3d& position) {
  Contact contact;
  contact.normal = Vector3d(1, 2, -0.5).normalized();
  contact.friction = 0.6;
  contact.gap = contact.normal.dot(position);
  return contact;
}

ContactTerms terms_at(const Vector3d& position, const Vector3d& force) {
  return augmented_contact(contact_at(position), force, position, penalty);
}

}  // namespace

TEST_CASE("a contact's force and stiffness are derivatives of its energy, of second order") {
  const Vector3d n = contact_at(Vector3d::Zero()).normal, t = n.unitOrthogonal();
  struct Case {
    const char* name;
    Vector3d position, force;
  };
  for (const Case& at : {Case{"sticks", 0.001 * t - 0.002 * n, 4 * n + t}, Case{"slides", 0.02 * t - 0.01 * n, 3 * n},
                         Case{"lifts off but drags still", 0.03 * n + 0.001 * t, 4 * n - t},
                         Case{"frictionless at first", -0.01 * n + 0.1 * t, Vector3d::Zero()}}) {
    CAPTURE(at.name);
    const ContactTerms terms = terms_at(at.position, at.force);
    double errors[2] = {0, 0};
    for (int level = 0; level < 2; ++level) {
      const double d = 2e-4 / (1 << level);
      for (int axis = 0; axis < 3; ++axis) {
        const ContactTerms ahead = terms_at(at.position + d * Vector3d::Unit(axis), at.force);
        const ContactTerms behind = terms_at(at.position - d * Vector3d::Unit(axis), at.force);
        CHECK(-(ahead.energy - behind.energy) / (2 * d) == Approx(terms.force[axis]).margin(1e-3));
        const Vector3d bend = -(ahead.force - behind.force) / (2 * d);
        errors[level] = std::max(errors[level], (bend - terms.stiffness.col(axis)).norm());
      }
    }
    CHECK(errors[0] < 1e-2 * penalty);
    if (errors[0] > 1e-7) CHECK(errors[1] < 0.3 * errors[0]);
    CHECK((terms.stiffness - terms.stiffness.transpose()).norm() < 1e-12 * penalty);
  }
}

TEST_CASE("an open contact without a force adds nothing") {
  const ContactTerms terms = terms_at({0.1, 0.1, 0}, Vector3d::Zero());
  CHECK(terms.energy == 0);
  CHECK(terms.force.norm() == 0);
  CHECK(terms.stiffness.norm() == 0);
}

TEST_CASE("friction pushes no harder than its disc lets it") {
  const Vector3d n = contact_at(Vector3d::Zero()).normal, t = n.unitOrthogonal();
  const ContactTerms terms = terms_at(5 * t, 2 * n);
  CHECK(n.dot(terms.force) == Approx(2));
  CHECK((terms.force - 2 * n + 0.6 * 2 * t).norm() < 1e-12);
}
