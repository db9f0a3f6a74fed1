// Systems on multigrids with rank-one terms, and their solutions.
#pragma once

#include <vector>

#include "core/step/multigrid_system.h"

namespace umax::test {

/// One of every third hex, of squared lengths that grow from `least` to `most`.
std::vector<RankOneTerm> random_terms(const Model& model, double least, double most);

/// Each hex's strain along z.
std::vector<RankOneTerm> strain_terms(const Model& model);

/// The term's vector by node: 3 #N.
VectorXd dense_term(const Model& model, const RankOneTerm& term);

/// The system of a model in its rest shape.
MultigridSystem system_at_rest(const Model& model, const std::vector<RankOneTerm>& terms);

/// Sets up the Schur complements of all levels again, as where terms are too many for factors.
void leave_unfactored(BodyGrid& grid);

struct Solved : LinearSolution, SaddlePointReport {};

/// Solves on, or from zero with a right-hand side of 3 #N.
Solved solve_on(const Model& model, const SaddlePointOptions& options, MultigridSystem& system);
Solved solve_from_rest(const Model& model, const VectorXd& b, const SaddlePointOptions& options,
                       MultigridSystem& system);

}  // namespace umax::test
