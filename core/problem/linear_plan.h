// Which linear solver the exact method uses for which body: chosen once, from traits that need no model, so that what a
// job will take can be told before there is one.
//
// A sparse Cholesky factor suits any hexes, and its time and memory grow faster than their number. Multigrids grow in
// proportion to it, need regular lattices, and know the true energy only, rotated as the hex's centre is.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/model/model.h"
#include "core/problem/step_options.h"

namespace umax {

/// What the choice asks of a body.
struct LinearTraits {
  std::string name;
  double hexes = 0;          // 0: not known yet
  bool is_regular = false;   // its cage is made of cells of one grid
  bool has_springs = false;  // pins hold points of it by springs
};

enum class LinearBackend { direct, multigrid };

struct LinearPlan {
  std::vector<LinearBackend> bodies;           // in the order of the traits
  std::optional<ErrorText> against_multigrid;  // what stands against it, whatever was chosen; none: nothing does

  /// Are the bodies, which are all alike so far, solved on multigrids?
  bool is_multigrid() const { return !bodies.empty() && bodies.front() == LinearBackend::multigrid; }
};

/// For bodies that are solved together. solver.linear where it can be had; where it is automatic, multigrids from the size
/// of a body on from which they are faster.
/// The paper's method has direct systems only.
LinearPlan plan_linear_solvers(const std::vector<LinearTraits>& bodies, const SolverOptions& solver);
LinearPlan plan_linear_solvers(const Model& model, const SolverOptions& solver);

/// Throws Error (bad_data) that names what stands against it where the exact method's solver.linear is multigrid and
/// the plan could not follow.
void require_solvable(const LinearPlan& plan, const SolverOptions& solver);

}  // namespace umax
