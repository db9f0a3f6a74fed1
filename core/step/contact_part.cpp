#include "core/step/contact_part.h"

#include <utility>

namespace umax {
namespace {

// the contacts' points are counted anew on each body, in the contacts' order
Delassus delassus_of(const Delassus& all, const std::vector<int>& contacts) {
  Delassus some;
  some.bodies.resize(all.bodies.size());
  std::vector<std::vector<int>> rows(all.bodies.size());  // of W, three for each point
  for (const int contact : contacts) {
    for_each_side(all, contact, [&](const Delassus::Side& side) {
      std::vector<int>& of_body = rows[std::size_t(side.body)];
      some.sides.push_back({side.body, int(of_body.size()) / 3, side.sign});
      for (int axis = 0; axis < 3; ++axis) of_body.push_back(3 * side.point + axis);
    });
    some.first_side.push_back(int(some.sides.size()));
  }
  for (std::size_t b = 0; b < rows.size(); ++b) some.bodies[b].W = all.bodies[b].W(rows[b], rows[b]);
  return some;
}

std::vector<ContactRow> rows_of(const std::vector<ContactRow>& all, const std::vector<int>& contacts) {
  std::vector<ContactRow> rows;
  for (const int contact : contacts) rows.push_back(all[std::size_t(contact)]);
  return rows;
}

VectorXd parts_of(const VectorXd& all, const std::vector<int>& contacts) {
  VectorXd some(3 * Eigen::Index(contacts.size()));
  for (std::size_t i = 0; i < contacts.size(); ++i)
    some.segment<3>(3 * Eigen::Index(i)) = all.segment<3>(3 * Eigen::Index(contacts[i]));
  return some;
}

}  // namespace

ContactPart::ContactPart(const ContactProblem& all, std::vector<int> contacts)
    : all_(all),
      contacts_(std::move(contacts)),
      delassus_(delassus_of(all.delassus, contacts_)),
      rows_(rows_of(all.contacts, contacts_)),
      q_(parts_of(all.q, contacts_)),
      problem_(make_contact_problem(delassus_, rows_, q_,
                                    {parts_of(all.proximal.centre, contacts_), all.proximal.weight})) {}

ContactState ContactPart::state_of(const ContactState& all) const {
  const VectorXd forces = parts_of(all.forces, contacts_);
  return {forces, motions_of(problem_, forces)};
}

ContactState ContactPart::state_of_all(const ContactState& state) const {
  VectorXd forces = VectorXd::Zero(3 * Eigen::Index(all_.count()));
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    forces.segment<3>(3 * Eigen::Index(contacts_[i])) = state.forces.segment<3>(3 * Eigen::Index(i));
  return {forces, motions_of(all_, forces)};
}

}  // namespace umax
