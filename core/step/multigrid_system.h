// The step's linear systems on multigrids, one per body: no matrix is ever stored.
//
//   A = diag(m (1/h^2 + alpha/h)) + sum_e (1 + sum lambda/U_max + beta/h) R_e Y K R_e^T
// R_e: of the hex's centre, K: of the whole energy. Rank-one terms of limits and the stiffness of contacts join as
// RankOneTerms. Limits on parts stiffen by their share of the whole at most, so that theirs is an upper bound.
#pragma once

#include <vector>

#include "core/linear/saddle/saddle_point.h"
#include "core/problem/step_contacts.h"

namespace umax {

struct BodyGrid {
  Multigrid multigrid;
  std::vector<int> cell_slots, node_slots;
  AlignedArray<float> stiffness;   // per cell [Pa]
  AlignedArray<double> positions;  // per node [m]
  SaddlePointMultigrid terms;
  SaddlePoint point;  // in units of
  double unit = 0;    // [N] so that nothing leaves the range of float; 0: no force has come yet
};

struct MultigridSystem {
  std::vector<BodyGrid> bodies;
  VectorXd offset_force;  // 3 #N [N] sum of g offset
};

/// Slots of the bricks that hold a body of these cells (0 for an irregular one): what the system's memory grows with.
double multigrid_slots(const Cells& cells);

MultigridSystem make_multigrid_system(const Model& model);

/// A at the positions. stiffening: #E, factors [-] on the hexes' stiffness beyond 1. terms: g g^T beside A, in any
/// order, whose `hex` counts the model's hexes.
void set_up(const StepProblem& problem, const Points& positions, const VectorXd& stiffening,
            const std::vector<RankOneTerm>& terms, MultigridSystem& system);

/// Begins to solve A x + sum g (g . x + offset) = b from x = 0, for b of 3 #N, zero at fixed nodes.
void begin(const Model& model, const VectorXd& b, MultigridSystem& system);

/// b += force.
void add_force(const Model& model, const VectorXd& force, MultigridSystem& system);

/// The same by forces at contacts, 3 for each.
void add_contact_forces(const Model& model, const std::vector<Contact>& contacts, const VectorXd& forces,
                        MultigridSystem& system);

/// Improves x, for the forces so far: iterations of all bodies, the largest errors of a body.
SaddlePointReport improve(const SaddlePointOptions& options, MultigridSystem& system);

/// How contacts move in x, 3 numbers for each.
VectorXd contact_motions(const Model& model, const std::vector<Contact>& contacts, const MultigridSystem& system);

struct LinearSolution {
  VectorXd x;         // 3 #N
  VectorXd products;  // g . x of each term, as handed in, in their order
};
LinearSolution solution_of(const Model& model, const MultigridSystem& system);

}  // namespace umax
