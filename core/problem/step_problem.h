// What one time step solves: the state that it starts from, materials and limits at its end, obstacles on their way.
#pragma once

#include <vector>

#include "core/contact/contact.h"
#include "core/problem/linear_plan.h"
#include "core/problem/step_pins.h"

namespace umax {

/// What changes with time in a model's materials.
struct Materials {
  VectorXd young;   // #E [Pa]
  VectorXd limits;  // #L [J] U_max
};
Materials materials_at(const Model& model, double time);

/// Made whole by begin_step() and constant during the step.
struct StepProblem {
  const Model* model = nullptr;
  const StepOptions* options = nullptr;
  LinearPlan plan;
  double h = 0;                        // [s]
  Points positions_t0;                 // #N x 3 [m]
  Points velocities_t0;                // #N x 3 [m/s]
  Materials materials;                 // at the end of the step; limits as core/problem/limit_recovery.h lets them
  VectorXd damping_mass;               // #N [1/s] Rayleigh alpha, at the end of the step
  VectorXd damping_stiffness;          // #E [s] Rayleigh beta, likewise
  std::vector<Matrix3d> rotations_t0;  // #E, none where no stiffness damps
  ContactStep contact;
  StepPins pins;  // at the end of the step
  // deeper vertices than this share of the penetration tolerance join the contacts, and no contact of a solution is
  // deeper: half, or in proportion to a solver tolerance that is tighter than the default
  double joining_share = 0;
};

/// What the step from the state to one time step later solves. Keeps the addresses of model, options and geometry.
/// known: as of begin_contact_step().
StepProblem begin_step(const Model& model, const StepOptions& options, const LinearPlan& plan,
                       const ContactGeometry& geometry, const State& state,
                       std::shared_ptr<Clearances> known = nullptr);

/// Throws Error (bad_data) unless StepOptions::forces has no rows, or a finite one for each node.
void require_forces(const Model& model, const Points& forces);

/// Node by node (x, y, z) as one vector of 3 #N, and back.
VectorXd flatten(const Points& points);
Points unflatten(const VectorXd& vector);

/// Zeroes the rows of fixed nodes.
void clear_fixed(const Model& model, Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns);

/// U/U_max of every limit at the positions, rotations fresh: #L.
VectorXd limit_ratios(const Model& model, const SolverOptions& solver, const Materials& materials,
                      const Points& positions);

}  // namespace umax
