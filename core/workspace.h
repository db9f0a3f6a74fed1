// The memory behind Workspace (core/step.h), for the step solvers.
#pragma once

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

}  // namespace umax
