#include "core/step/contact_problem.h"

#include <utility>

namespace umax {

ContactProblem make_contact_problem(const Delassus& delassus, const std::vector<ContactRow>& contacts,
                                    const VectorXd& q, ProximalTerm proximal) {
  ContactProblem problem{
      .delassus = delassus, .contacts = contacts, .q = q, .proximal = std::move(proximal), .gives = {}, .blocks = {}};
  for (int i = 0; i < problem.count(); ++i) {
    const Matrix3d own = compliance(delassus, i, i);
    const Vector3d& normal = contacts[std::size_t(i)].normal;
    problem.gives.push_back(problem.proximal.weight * normal.dot(own * normal));
    problem.blocks.push_back(make_contact_block(own + problem.gives.back() * Matrix3d::Identity(), normal));
  }
  problem.free_motions = motions_of(problem, VectorXd::Zero(q.size()));
  return problem;
}

std::vector<VectorXd> motions_of(const ContactProblem& problem, const VectorXd& forces) {
  const Delassus& delassus = problem.delassus;
  std::vector<VectorXd> motions = at_points(problem.delassus, forces);
  for (std::size_t b = 0; b < motions.size(); ++b) motions[b] = delassus.bodies[b].W * motions[b];
  for (int i = 0; i < problem.count(); ++i) {
    const Delassus::Side& side = delassus.sides[delassus.first_side[i]];
    motions[side.body].segment<3>(3 * side.point) += problem.q.segment<3>(3 * i);
  }
  return motions;
}

Vector3d motion_of(const ContactProblem& problem, const ContactState& state, int contact) {
  Vector3d w = Vector3d::Zero();
  for_each_side(problem.delassus, contact, [&](const Delassus::Side& side) {
    w += side.sign * state.motions[side.body].segment<3>(3 * side.point);
  });
  return w + problem.gives[std::size_t(contact)] *
                 (state.forces.segment<3>(3 * contact) - problem.proximal.centre.segment<3>(3 * contact));
}

void count_change(const ContactProblem& problem, int contact, const Vector3d& change, const Vector3d& force,
                  ForceChanges& changes) {
  for_each_side(problem.delassus, contact, [&](const Delassus::Side& side) {
    changes.add(side.body, change.cwiseAbs().maxCoeff(), force.cwiseAbs().maxCoeff());
  });
}

double what_is_left(const ContactProblem& problem, const ContactState& state) {
  ForceChanges changes(problem.delassus.bodies.size());
  for (int i = 0; i < problem.count(); ++i) {
    const Vector3d force = state.forces.segment<3>(3 * i);
    count_change(problem, i,
                 relaxed_force(problem.contacts[i], problem.blocks[i], motion_of(problem, state, i), force) - force,
                 force, changes);
  }
  return changes.largest();
}

}  // namespace umax
