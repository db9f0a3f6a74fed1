// What a time step is asked to do: which method solves it, to what tolerance, and what it tells while it works.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/element/energy_limit.h"

namespace umax {

enum class SolverMethod {
  exact,  // docs/solvers.md, Sequential quadratic programming: limits in the matrix, contacts by Schur complement
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

/// A point of a body that a spring pulls to a place during a step.
struct Pull {
  std::string body;                     // its name
  int hex = 0;                          // of the body
  Vector8d weights = Vector8d::Zero();  // of the hex's nodes
  double stiffness = 0;                 // [N/m]
  Vector3d place = Vector3d::Zero();    // [m]
};

struct StepOptions {
  double time_step = 1.0 / 60;    // [s]
  Vector3d gravity{0, -9.81, 0};  // [m/s^2]
  SolverOptions solver{};
  std::vector<Pull> pulls{};  // of this step; multigrids do not know them
  Points forces{};  // #N x 3 [N] from outside on nodes, the whole step long; no rows: none. Fixed nodes bear theirs
  /// Called once an iteration when set. What it throws ends the step; its state is then as before.
  std::function<void(const IterationReport&)> on_iteration{};
};

}  // namespace umax
