#include "core/step/held_contacts.h"

#include <Eigen/Geometry>

namespace umax {
namespace {

constexpr double spring_share = 0.3;  // [-] of contact_penalty(): ten times that is harder to solve, a tenth moves more
constexpr double sticking_share = 0.999;  // [-] of the friction that a contact can bear, from which it slides
// groups of terms: what holds neighbours along their normals, along either tangent
constexpr int along_normal = 1, along_tangents[] = {2, 3};

Vector3d a_tangent(const Vector3d& normal) {
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  return normal.cross(Vector3d::Unit(axis)).normalized();
}

// [-] how much stiffer limits make the hex
double stiffening_of(const Model& model, const Linearisation& at, int hex) {
  double factor = 1;
  for (int l = model.limit_starts[hex]; l < model.limit_starts[hex + 1]; ++l) factor += at.limits[l].stiffening;
  return factor;
}

}  // namespace

HeldContacts hold_contacts(const StepProblem& problem, const Linearisation& at, const Iterate& iterate) {
  const auto [rows, before] = contact_rows(problem, iterate.positions, iterate.contacts);
  HeldContacts held;
  for (int i = 0; i < int(iterate.contacts.size()); ++i) {
    const Contact& contact = iterate.contacts[i];
    const Vector3d& normal = contact.normal;
    const double pushes = contact.force.dot(normal);
    if (contact.between_bodies() || !(pushes > 0)) continue;
    const double stiffness =
        spring_share * contact_penalty(problem, contact) * stiffening_of(*problem.model, at, contact.support.hex);
    const Vector3d so_far = before.segment<3>(3 * Eigen::Index(i));
    const double gap = rows[i].bias + normal.dot(so_far);
    if (!(pushes - stiffness * gap > 0)) continue;
    held.push_back({i, normal, stiffness, -gap, along_normal});
    const Vector3d slip = so_far - normal.dot(so_far) * normal;
    const double friction = (contact.force - pushes * normal - stiffness * slip).norm();
    if (!(friction < sticking_share * contact.friction * pushes)) continue;
    const Vector3d first = a_tangent(normal), second = normal.cross(first);
    held.push_back({i, first, stiffness, -first.dot(so_far), along_tangents[0]});
    held.push_back({i, second, stiffness, -second.dot(so_far), along_tangents[1]});
  }
  return held;
}

std::vector<RankOneTerm> spring_terms(const std::vector<Contact>& contacts, const HeldContacts& held) {
  std::vector<RankOneTerm> terms;
  for (const HeldDirection& one : held) {
    RankOneTerm term = spring_term(contacts[one.contact].support, one.direction, one.stiffness);
    term.group = one.group;
    terms.push_back(term);
  }
  return terms;
}

VectorXd spring_forces(const HeldContacts& held, const VectorXd& motions) {
  VectorXd forces = VectorXd::Zero(motions.size());
  for (const HeldDirection& one : held) {
    const Eigen::Index at = 3 * Eigen::Index(one.contact);
    forces.segment<3>(at) -= one.stiffness * one.direction.dot(motions.segment<3>(at)) * one.direction;
  }
  return forces;
}

VectorXd target_motions(const HeldContacts& held, std::size_t num_contacts) {
  VectorXd motions = VectorXd::Zero(3 * Eigen::Index(num_contacts));
  for (const HeldDirection& one : held) motions.segment<3>(3 * Eigen::Index(one.contact)) += one.target * one.direction;
  return motions;
}

}  // namespace umax
