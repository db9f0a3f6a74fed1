// One time step of the whole model: backward Euler with energy limits and frictional contact.
#pragma once

#include <memory>
#include <vector>

#include "core/contact/overlap.h"
#include "core/model/model.h"
#include "core/problem/step_options.h"

namespace umax {

enum class StepStatus {
  converged,
  iteration_limit,  // did not reach the tolerance: more substeps, a looser tolerance or a softer limit help
  infeasible,       // no state nearby obeys all limits and contacts, or the run began beyond its limits and is not back
};

struct StepReport {
  StepStatus status = StepStatus::converged;
  int limits_active = 0;  // hexes that a limit holds: with a positive multiplier
  int contacts = 0;       // contact constraints solved
  int contacts_obstacles = 0, contacts_between = 0, contacts_within = 0;  // of these: with obstacles, of two bodies, of
                                                                          // a body with itself
  int sqp_iterations = 0;
  int factorisations = 0;
  int linear_iterations = 0;    // Gauss-Seidel sweeps
  int retries = 0;              // at smaller step sizes
  int substeps = 1;             // solves that the step was made of: more where bodies move fast towards each other
  double max_energy_ratio = 0;  // [-] U/U_max of the worst limit at the end, fresh rotations
  double kkt_residual = 0;      // [-]
  double max_penetration = 0;   // [m] deepest surface vertex at the end
  double kinetic_energy = 0;    // [J]
  double elastic_energy = 0;    // [J]
  double potential_energy = 0;  // [J] gravity, zero at height 0
};

/// Memory that steps reuse: symbolic analysis, element buffers. May be rebuilt at any step with the same bytes.
class Workspace {
 public:
  explicit Workspace(const Model& model);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  struct Data;
  Data& data() { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

/// Advances state by one time step. Deterministic for any number of threads. Throws Error (bad_data) where
/// solver.energy names an energy that the model's limits cannot measure (require_measurable()), or solver.linear a
/// solver that does not suit the model (require_solvable()), or forces are not one finite vector for each node.
StepReport step(const Model& model, const StepOptions& options, Workspace& workspace, State& state);

/// The measured quantities of a state, without stepping.
StepReport measure(const Model& model, const StepOptions& options, const State& state);

/// Bodies inside each other at a state, deeper than what counts as touching.
std::vector<Overlap> find_overlaps(const Model& model, const State& state);

/// How deep each point of Model::surface is in another body or a far part of its own [m], 0 where it merely touches: #P.
VectorXd overlap_depths(const Model& model, const State& state);

/// U/U_max of each hex's worst limit (0 where it has none), freshly computed rotations: #E.
VectorXd energy_ratios(const Model& model, const SolverOptions& solver, const State& state);

}  // namespace umax
