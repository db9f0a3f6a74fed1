// The memory behind Workspace (core/step/step.h), for the step solvers.
#pragma once

#include <optional>
#include <vector>

#include "core/contact/contact.h"
#include "core/linear/direct/sparse_cholesky.h"
#include "core/linear/direct/system_matrix.h"
#include "core/step/multigrid_system.h"
#include "core/step/step.h"

namespace umax {

struct Workspace::Data {
  ContactGeometry contact_geometry;
  std::optional<SystemMatrix> matrix;  // of the direct solver; made when first needed, as are the others
  SparseCholesky cholesky;
  std::optional<MultigridSystem> multigrid;
};

/// The matrix of the direct solver, in an order of its own where eliminate_last() has not been told otherwise.
SystemMatrix& direct_matrix(const Model& model, Workspace::Data& workspace);

/// Brings the matrix into an order in which these nodes (ascending) are eliminated last; keeps it if they are already.
void eliminate_last(const Model& model, const std::vector<int>& nodes, Workspace::Data& workspace);

/// The multigrids of the model's bodies.
MultigridSystem& multigrid_system(const Model& model, Workspace::Data& workspace);

}  // namespace umax
