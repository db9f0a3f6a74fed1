// The memory behind Workspace (core/step/step.h), for the step solvers.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/contact/contact.h"
#include "core/linear/direct/sparse_cholesky.h"
#include "core/linear/direct/system_matrix.h"
#include "core/step/multigrid_system.h"
#include "core/step/step.h"

namespace umax {

struct Island;

/// A matrix and its factor; made when first needed.
struct DirectSystem {
  std::optional<SystemMatrix> matrix;
  SparseCholesky cholesky;
};

struct Workspace::Data {
  ContactGeometry contact_geometry;
  std::vector<DirectSystem> bodies;  // the exact method's, one per body
  DirectSystem all;                  // the paper's method's: of all bodies
  std::optional<MultigridSystem> multigrid;
  std::vector<std::unique_ptr<Island>> islands;  // of the last step, where bodies were solved apart
  std::shared_ptr<Clearances> clearances;        // of the last step's searches, where no bodies started deep
  std::shared_ptr<Clearances> measured;          // of searches that measure how deep bodies are inside each other
  std::vector<std::vector<char>> active_pins;    // per body, for which `pinned` was made
  std::unique_ptr<Model> pinned;                 // core/step/pinned_model.h
  bool may_tear = false;  // pins hold in this step what they held before it, so that limits may be passed in both

  Data();
  Data(Data&&) noexcept;
  Data& operator=(Data&&) noexcept;
  ~Data();
};

/// The matrix of all bodies.
SystemMatrix& matrix_of_all(const Model& model, Workspace::Data& workspace);

/// The matrix of one body, in an order of its own where eliminate_last() has not been told otherwise.
SystemMatrix& body_matrix(const Model& model, int body, Workspace::Data& workspace);

/// Brings the body's matrix into an order in which these of its nodes (ascending, counted from its first) are eliminated
/// last; keeps it if they are already.
void eliminate_last(const Model& model, int body, const std::vector<int>& nodes, Workspace::Data& workspace);

/// x becomes A^-1 x, body by body: 3 #N.
void solve(const Model& model, const Workspace::Data& workspace, VectorXd& x);

/// The two halves of that: x becomes L^-1 x, each body's unknowns in elimination order; and L^-T x from there.
void solve_forward(const Model& model, const Workspace::Data& workspace, VectorXd& x);
void solve_backward(const Model& model, const Workspace::Data& workspace, VectorXd& x);

/// The multigrids of the model's bodies.
MultigridSystem& multigrid_system(const Model& model, Workspace::Data& workspace);

}  // namespace umax
