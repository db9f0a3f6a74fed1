#include "core/problem/step_contacts.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/contact/held_vertex.h"
#include "core/contact/surface_contact.h"

namespace umax {
namespace {

constexpr double relative_contact_penalty = 100;  // of the stiffness and inertia of what touches

}  // namespace

Vector3d relative_motion(const StepProblem& problem, const Points& positions, const Contact& contact) {
  Vector3d moved = Vector3d::Zero();
  for_each_node(*problem.model, contact, [&](int node, double weight) {
    moved += weight * (positions.row(node) - problem.positions_t0.row(node)).transpose();
  });
  return moved - contact.obstacle_motion;
}

ContactRows contact_rows(const StepProblem& problem, const Points& positions, const std::vector<Contact>& contacts) {
  ContactRows result{{}, VectorXd(3 * Eigen::Index(contacts.size()))};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    const Vector3d motion = relative_motion(problem, positions, contact);
    result.motions.segment<3>(3 * Eigen::Index(i)) = motion;
    result.rows.push_back({contact.normal, contact.friction, contact.gap - contact.normal.dot(motion)});
  }
  return result;
}

double contact_penalty(const StepProblem& problem, const Contact& contact) {
  const Model& model = *problem.model;
  double stiffness = std::numeric_limits<double>::infinity();  // of the softer hex
  for_each_support(contact, [&](const Support& support, double) {
    const double cell_size = body_of(model, support.hex).cell_size;
    stiffness = std::min(stiffness, problem.materials.young[support.hex] * cell_size);
  });
  return relative_contact_penalty * (stiffness + contact_mass(model, contact) / (problem.h * problem.h));
}

void remember_apart(const Model& model, const std::vector<Contact>& contacts, const Points& positions,
                    LastApart& apart) {
  LastApart now(positions);
  for (const Contact& contact : contacts) {
    if (!contact.between_bodies() || contact.gap >= -nearly_outside * tolerance_depth(model, contact)) continue;
    const std::pair<int, int> key(contact.support.hex, model.hex_body[contact.other.hex]);
    const auto found = apart.before.find(key);
    now.before[key] = found == apart.before.end() ? apart.latest : found->second;
  }
  apart = std::move(now);
}

double deepest(const std::vector<Contact>& contacts) {
  double depth = 0;
  for (const Contact& contact : contacts) depth = std::max(depth, -contact.gap);
  return depth;
}

void remember_contacts(const StepProblem& problem, const std::vector<Contact>& contacts, State& state) {
  state.contacts.clear();
  const auto remember = [&](const Contact& contact) {
    state.contacts.push_back({contact.point, contact.obstacle, contact.support.hex,
                              contact.between_bodies() ? contact.other.hex : -1, problem.h * contact.force});
  };
  for (const Contact& contact : contacts)
    if (contact.force.squaredNorm() > 0) remember(contact);
  for (const Contact& contact : problem.contact.deep_start.contacts)
    if (std::none_of(state.contacts.begin(), state.contacts.end(), [&](const State::ContactImpulse& memory) {
          return memory.obstacle < 0 && memory.point.index == contact.point.index &&
                 memory.other_hex == contact.other.hex;
        }))
      remember(contact);
}

std::vector<Contact> recall_contacts(const StepProblem& problem, const State& state, const Points& positions) {
  const Model& model = *problem.model;
  std::vector<Contact> contacts;
  std::map<std::pair<int, int>, std::size_t> of_vertices;  // against bodies: planes that held one are not remembered
  for (const State::ContactImpulse& memory : state.contacts) {
    if (memory.obstacle < 0) {
      const std::pair<int, int> key(memory.point.index, model.hex_body[memory.other_hex]);
      const auto [known, is_new] = of_vertices.try_emplace(key, contacts.size());
      if (is_new) contacts.push_back(make_surface_contact(model, memory.point.index, memory.hex, memory.other_hex));
      contacts[known->second].force += memory.impulse / problem.h;
    } else {
      contacts.push_back(make_contact(model, memory.point, memory.obstacle, memory.hex));
      contacts.back().force = memory.impulse / problem.h;
    }
  }
  const LastApart apart(problem.positions_t0);
  place_surface_contacts(problem.contact, apart, problem.positions_t0, contacts);
  std::erase_if(contacts, [](const Contact& contact) { return contact.normal.isZero(0); });
  update_contacts(problem.contact, apart, positions, contacts);
  return contacts;
}

}  // namespace umax
