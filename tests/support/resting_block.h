// A block that rests on the ground, as a system on multigrids.
#pragma once

#include <vector>

#include "core/step/multigrid_system.h"
#include "tests/support/begun_step.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/double_operator.h"

namespace umax::test {

/// A block at rest, more than the last level's nodes, with contacts under all of its lowest hexes.
struct Resting : BegunStep {
  std::vector<Contact> contacts;
  MultigridSystem system = make_multigrid_system(model);

  // every seventh hex is `stiffer` times as stiff, and one more
  explicit Resting(const std::vector<RankOneTerm>& terms = {}, double stiffer = 0)
      : BegunStep(make_model({make_block({6, 7, 8}, {0, 0, 0}, 0.1)}, {make_ground(0.5)})) {
    const Points pushed_in = state.positions.rowwise() - Eigen::RowVector3d(0, 1e-3, 0);
    add_contacts(problem.contact, LastApart(pushed_in), pushed_in, 0, contacts);
    REQUIRE(contacts.size() == 48);
    VectorXd stiffening = VectorXd::Zero(model.num_hexes());
    for (Eigen::Index e = 0; e < stiffening.size(); e += 7) stiffening[e] = stiffer;
    set_up(problem, state.positions, stiffening, terms, system);
  }

  // A, column by column
  MatrixXd matrix() {
    BodyGrid& grid = system.bodies.front();
    const MultigridLevel& level = grid.multigrid.levels.front();
    MatrixXd A(3 * model.num_nodes(), 3 * model.num_nodes());
    AlignedArray<double> x(level.lattice().num_slots() * vector_components), y(x.size());
    for (Eigen::Index i = 0; i < A.cols(); ++i) {
      to_bricks(grid.node_slots, VectorXd::Unit(A.cols(), i), x);
      apply(level.op, level.matrix, x, y);
      VectorXd column;
      from_bricks(grid.node_slots, y, column);
      A.col(i) = column;
    }
    return A;
  }
};

}  // namespace umax::test
