// The Schur complement of terms on multigrids, its slices and its factor, against dense algebra.
#include "core/linear/saddle/limit_schur_complement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/linear/bricks/hadamard_hex.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/resting_block.h"
#include "tests/support/systems_with_terms.h"

using namespace umax;
using test::leave_unfactored, test::random_terms, test::Resting, test::Solved, test::solve_from_rest,
    test::system_at_rest;

namespace {

// S of the first level's terms, column by column
MatrixXd dense_complement(const BodyGrid& grid) {
  const MultigridLevel& level = grid.multigrid.levels.front();
  const RankOneTerms& terms = grid.terms.levels.front().terms;
  const auto count = Eigen::Index(terms.vectors.size());
  AlignedArray<float> pushes(grid.positions.size()), moves(grid.positions.size());
  MatrixXd S(count, count);
  const double w = 1.9 / largest_jacobi_eigenvalue(level.shape);
  for (Eigen::Index i = 0; i < count; ++i) {
    std::fill(pushes.begin(), pushes.end(), 0.f);
    add(terms, VectorXd(VectorXd::Unit(count, i)), pushes);
    VectorXd force;
    from_bricks(grid.node_slots, pushes, force);
    for (std::size_t n = 0; n < grid.node_slots.size(); ++n) {
      auto at_node = force.segment<3>(3 * Eigen::Index(n));
      at_node = (w * inverse_block(level.inverse, grid.node_slots[n]).cast<double>() * at_node).eval();
    }
    to_bricks(grid.node_slots, force, moves);
    VectorXd products(count);
    multiply(terms, moves, products);
    S.col(i) = products + VectorXd::Unit(count, i);
  }
  return S;
}

// the scaled S as the kernels apply it, times a unit vector
VectorXd column_of_slices(const SlicedEllMatrix& S, InstructionSet set, Eigen::Index column) {
  const auto slices = Eigen::Index(S.below.size());
  VectorXf move = VectorXf::Zero(slices * slice_stride), next = move;
  VectorXf rest = VectorXf::Zero(slices * brick_lanes), x = rest;
  const int lane = S.lanes[std::size_t(column)] % brick_lanes, slice = S.lanes[std::size_t(column)] / brick_lanes;
  move[slice * slice_stride + 1 + lane] = 1;
  if (lane == 0 && S.below[slice] >= 0) move[S.below[slice] * slice_stride + brick_lanes + 1] = 1;
  if (lane == brick_lanes - 1 && S.above[slice] >= 0) move[S.above[slice] * slice_stride] = 1;
  SliceSweep sweep{.slices = slices_of(S)};
  sweep.move = move.data(), sweep.next = next.data(), sweep.rest = rest.data(), sweep.x = x.data();
  multigrid_kernels(set).sweep_slices(sweep, 0, int(slices));
  VectorXd product(S.scale.size());
  for (Eigen::Index t = 0; t < product.size(); ++t) product[t] = -double(rest[S.lanes[std::size_t(t)]]);
  return product;
}

}  // namespace

TEST_CASE("slices of terms couple those that share a node, wherever their lines end and however many a hex has") {
  const Model model = make_model({test::make_block({3, 4, 37}, {0, 0, 0}, 0.1)}, {});
  test::Random random(11);
  std::vector<RankOneTerm> terms;
  for (int hex = 0; hex < int(model.num_hexes()); ++hex)
    for (int layer = int(random.uniform(-2, 4)); layer > 0; --layer) {
      RankOneTerm term{hex, Vector24d::Zero(), 0};
      for (double& value : term.vector) value = random.uniform(-3e3, 3e3);
      terms.push_back(term);
    }
  REQUIRE(terms.size() > 300);
  MultigridSystem system = system_at_rest(model, terms);
  leave_unfactored(system.bodies.front());
  const SlicedEllMatrix& complement = system.bodies.front().terms.levels.front().complement.matrix;
  const VectorXd scale = complement.scale.cast<double>();
  const MatrixXd scaled = scale.asDiagonal() * dense_complement(system.bodies.front()) * scale.asDiagonal();
  for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    CAPTURE(int(set));
    double error = 0;
    for (Eigen::Index t = 0; t < scaled.cols(); ++t)
      error = std::max(error, (column_of_slices(complement, set, t) - scaled.col(t)).cwiseAbs().maxCoeff());
    CHECK(error <= 3e-5);  // entries are multiples of 1 / 32767
  }
}

TEST_CASE("the Schur complement of terms is what they do to each other through single nodes") {
  Resting resting(random_terms(Resting().model, 1e4, 1e6));
  BodyGrid& grid = resting.system.bodies.front();
  const SaddlePointLevel& level = grid.terms.levels.front();
  const MatrixXd S = dense_complement(grid);
  const Eigen::Index count = S.cols();
  const LimitSchurComplement factored = level.complement;
  leave_unfactored(grid);
  const LimitSchurComplement& many = level.complement;
  const VectorXd scale = many.scale.cast<double>();
  const MatrixXd scaled = scale.asDiagonal() * S * scale.asDiagonal();
  CHECK((scaled.diagonal() - VectorXd::Ones(count)).cwiseAbs().maxCoeff() <= 1e-5);
  const double largest = Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled).eigenvalues().maxCoeff();
  CHECK(largest <= double(many.matrix.largest));
  CHECK(double(many.matrix.largest) <= 2 * largest);
  const VectorXd x = VectorXd::LinSpaced(count, -1, 2).cwiseProduct(scale), b = S * x;
  const auto left_over = [&](LimitSchurComplement complement) {
    const VectorXd solved = solve(complement, VectorXf(b.cast<float>())).cast<double>();
    return (S * solved - b).cwiseProduct(scale).norm() / b.cwiseProduct(scale).norm();
  };
  REQUIRE(factored.is_factored);
  CHECK(left_over(factored) <= 1e-3);
  CHECK(factored.scale == many.scale);
  REQUIRE_FALSE(many.is_factored);  // but solved for by Chebyshev's steps
  CHECK(left_over(many) <= 0.3);
}

TEST_CASE("terms that are too many for a factor are solved for as those that have one") {
  Resting resting(random_terms(Resting().model, 1e4, 1e6));
  const VectorXd b = VectorXd::LinSpaced(3 * resting.model.num_nodes(), -1, 2);
  const SaddlePointOptions options{.tolerance = 1e-7};
  const Solved factored = solve_from_rest(resting.model, b, options, resting.system);
  leave_unfactored(resting.system.bodies.front());
  const Solved many = solve_from_rest(resting.model, b, options, resting.system);
  CAPTURE(factored.iterations, many.iterations);
  CHECK((many.x - factored.x).norm() <= 1e-4 * factored.x.norm());
  CHECK(many.iterations <= 60);
}
