// The memory behind Workspace (core/step.h), for the step solvers.
#pragma once

#include <vector>

#include "core/contact.h"
#include "core/sparse_cholesky.h"
#include "core/step.h"
#include "core/system_matrix.h"

namespace umax {

struct Workspace::Data {
  ContactGeometry contact_geometry;
  SystemMatrix matrix;
  SparseCholesky cholesky;
};

/// Brings the matrix into an order in which these nodes (ascending) are eliminated last; keeps it if they are already.
void eliminate_last(const Model& model, const std::vector<int>& nodes, Workspace::Data& workspace);

}  // namespace umax
