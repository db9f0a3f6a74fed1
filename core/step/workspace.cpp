#include "core/step/workspace.h"

#include "core/step/islands.h"

namespace umax {

namespace {

// Calls visit(factor, the body's part of x) for each body, several at a time.
template <class Visit>
void for_each_body(const Model& model, const Workspace::Data& workspace, VectorXd& x, const Visit& visit) {
  for_each_solve(Eigen::Index(model.bodies.size()), [&](Eigen::Index b) {
    const Model::BodyRange& body = model.bodies[std::size_t(b)];
    visit(workspace.bodies[std::size_t(b)].cholesky, x.segment(3 * body.first_node, 3 * body.num_nodes));
  });
}

}  // namespace

Workspace::Data::Data() = default;
Workspace::Data::Data(Data&&) noexcept = default;
Workspace::Data& Workspace::Data::operator=(Data&&) noexcept = default;
Workspace::Data::~Data() = default;

SystemMatrix& matrix_of_all(const Model& model, Workspace::Data& workspace) {
  if (!workspace.all.matrix) workspace.all.matrix = make_system_matrix(model);
  return *workspace.all.matrix;
}

SystemMatrix& body_matrix(const Model& model, int body, Workspace::Data& workspace) {
  DirectSystem& system = workspace.bodies[body];
  if (!system.matrix) system.matrix = make_body_matrix(model, model.bodies[body]);
  return *system.matrix;
}

void eliminate_last(const Model& model, int body, const std::vector<int>& nodes, Workspace::Data& workspace) {
  DirectSystem& system = workspace.bodies[body];
  if (system.matrix && nodes == system.matrix->last) return;
  system.matrix = make_body_matrix(model, model.bodies[body], nodes);
  system.cholesky = SparseCholesky();
}

void solve(const Model& model, const Workspace::Data& workspace, VectorXd& x) {
  for_each_body(model, workspace, x, [](const SparseCholesky& factor, auto part) { factor.solve(part); });
}

void solve_forward(const Model& model, const Workspace::Data& workspace, VectorXd& x) {
  for_each_body(model, workspace, x,
                [](const SparseCholesky& factor, auto part) { part = factor.solve_forward(part); });
}

void solve_backward(const Model& model, const Workspace::Data& workspace, VectorXd& x) {
  for_each_body(model, workspace, x,
                [](const SparseCholesky& factor, auto part) { part = factor.solve_backward(part); });
}

MultigridSystem& multigrid_system(const Model& model, Workspace::Data& workspace) {
  if (!workspace.multigrid) workspace.multigrid = make_multigrid_system(model);
  return *workspace.multigrid;
}

}  // namespace umax
