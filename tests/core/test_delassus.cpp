// The compliance of contact points, as a product of half-solved columns, against solves with the whole matrix.
#include "core/step/delassus.h"

#include <vector>

#include "core/contact/contact_support.h"
#include "core/step/newton_system.h"
#include "tests/support/begun_step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

std::vector<Contact> contacts_with_ground(const Model& model, int count) {
  std::vector<Contact> contacts;
  for (int vertex = 0; vertex < count; ++vertex)
    contacts.push_back(make_contact(model, {ContactKind::vertex, vertex}, 0, surface_hex(model, vertex)));
  return contacts;
}

// J A^-1 J^T, a column at a time
MatrixXd compliance_by_solves(const Model& model, const Workspace::Data& workspace,
                              const std::vector<Contact>& contacts) {
  const auto size = 3 * Eigen::Index(contacts.size());
  MatrixXd W(size, size);
  for (Eigen::Index column = 0; column < size; ++column) {
    VectorXd x = VectorXd::Zero(3 * model.num_nodes());
    spread(model, contacts[std::size_t(column / 3)], Vector3d::Unit(column % 3), x);
    clear_fixed(model, x);
    solve(model, workspace, x);
    for (std::size_t i = 0; i < contacts.size(); ++i)
      W.block<3, 1>(3 * Eigen::Index(i), column) = contact_motion(model, contacts[i], x);
  }
  return W;
}

}  // namespace

TEST_CASE("the compliance of many points of one body is what solves say, in whatever parts its contacts come") {
  const test::BegunStep begun(make_model({test::make_block({5, 3, 4}, {0, 0.1, 0}, 0.1)}, {test::make_ground(0.5)}));
  const Model& model = begun.model;
  const StepProblem& problem = begun.problem;
  Workspace workspace(model);
  Iterate iterate = predict(problem, begun.state);
  evaluate(problem, iterate.positions, iterate.evaluation);
  factorize(problem, {limit_terms(problem, iterate, 1e4), {}}, iterate, workspace.data());
  const std::vector<Contact> contacts = contacts_with_ground(model, 150);
  const MatrixXd W = compliance_by_solves(model, workspace.data(), contacts);
  for (const std::vector<int>& parts : {std::vector{150}, {1, 150}, {64, 65, 140, 150}, {20, 100, 150}}) {
    Delassus delassus;
    for (const int count : parts)
      extend(model, workspace.data(), {contacts.begin(), contacts.begin() + count}, delassus);
    CHECK((dense(delassus) - W).norm() < 1e-12 * W.norm());
  }
}
