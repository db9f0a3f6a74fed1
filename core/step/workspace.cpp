#include "core/step/workspace.h"

namespace umax {

SystemMatrix& direct_matrix(const Model& model, Workspace::Data& workspace) {
  if (!workspace.matrix) workspace.matrix = make_system_matrix(model);
  return *workspace.matrix;
}

void eliminate_last(const Model& model, const std::vector<int>& nodes, Workspace::Data& workspace) {
  if (workspace.matrix && nodes == workspace.matrix->last) return;
  workspace.matrix = make_system_matrix(model, nodes);
  workspace.cholesky = SparseCholesky();
}

MultigridSystem& multigrid_system(const Model& model, Workspace::Data& workspace) {
  if (!workspace.multigrid) workspace.multigrid = make_multigrid_system(model);
  return *workspace.multigrid;
}

}  // namespace umax
