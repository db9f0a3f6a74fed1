// One time step of the whole model: backward Euler with energy limits and frictional contact.
#pragma once

#include <functional>
#include <memory>

#include "core/energy_limit.h"
#include "core/model.h"

namespace umax {

enum class SolverMethod {
  exact,  // hybrid SQP: limits in the matrix, contacts by Schur complement (THEORY 5)
  paper,  // [PPO13] Sect. 5 in its accumulating form: limits and contacts in one projected Gauss-Seidel
};

// Of the exact method's linear systems.
enum class LinearSolver {
  automatic,  // what is faster for the model
  direct,     // sparse Cholesky: any hexes; time and memory grow faster than their number
  multigrid,  // matrix-free: regular lattices; time and memory in proportion to their number
};

struct SolverOptions {
  SolverMethod method = SolverMethod::exact;
  LinearSolver linear = LinearSolver::automatic;
  double tolerance = 1e-3;  // [-] bound on U/U_max - 1 at the end of a step
  EnergyMeasure energy = EnergyMeasure::true_energy;
  RotationEstimate rotation = RotationEstimate::centre;
  LimitJacobian jacobian = LimitJacobian::exact;
  int max_iterations = 100;            // paper: re-linearisations a step
  int max_newton_iterations = 20;      // exact: after which a line search takes over; on multigrids 2 to 3 times
  int max_augmented_iterations = 100;  // exact: factorisations of the line search after which the step is halved
  int max_halvings = 6;                // exact: of a step that does not converge
  int max_sweeps = 2000;               // Gauss-Seidel sweeps a re-linearisation
  double sweep_tolerance = 1e-6;       // [-] relative change at which the sweeps stop
};

/// What a solver knows in the middle of a step.
struct IterationReport {
  int iteration = 0;
  double max_energy_ratio = 0;  // [-]
  double max_penetration = 0;   // [m] of the contacts in the working set
  double largest_move = 0;      // [cells] of a node in the last iteration
  double kkt_residual = 0;      // [-] exact method; 0: paper, which has none before its end
  int limits_active = 0;
  int contacts = 0;
};

struct StepOptions {
  double time_step = 1.0 / 60;    // [s]
  Vector3d gravity{0, -9.81, 0};  // [m/s^2]
  SolverOptions solver{};
  /// Called once an iteration when set. What it throws ends the step; its state is then as before.
  std::function<void(const IterationReport&)> on_iteration{};
};

enum class StepStatus {
  converged,
  iteration_limit,  // did not reach the tolerance: more substeps, a looser tolerance or a softer limit help
  infeasible,       // no state nearby obeys all limits and contacts, or the run began beyond its limits and is not back
};

struct StepReport {
  StepStatus status = StepStatus::converged;
  int limits_active = 0;  // hexes that a limit holds: with a positive multiplier
  int contacts = 0;       // contact constraints solved
  int sqp_iterations = 0;
  int factorisations = 0;
  int linear_iterations = 0;    // Gauss-Seidel sweeps
  int retries = 0;              // at smaller step sizes
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
/// solver that does not suit the model (require_solvable()).
StepReport step(const Model& model, const StepOptions& options, Workspace& workspace, State& state);

/// The measured quantities of a state, without stepping.
StepReport measure(const Model& model, const StepOptions& options, const State& state);

/// U/U_max of each hex's worst limit (0 where it has none), freshly computed rotations: #E.
VectorXd energy_ratios(const Model& model, const SolverOptions& solver, const State& state);

}  // namespace umax
