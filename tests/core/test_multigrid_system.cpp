// Systems with terms on multigrids against dense algebra.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/linear/multigrid/multigrid_cycle.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"
#include "tests/support/resting_block.h"
#include "tests/support/systems_with_terms.h"

using namespace umax;
using test::dense_term, test::leave_unfactored, test::random_terms, test::strain_terms, test::Resting, test::Solved,
    test::solve_from_rest, test::solve_on, test::system_at_rest;

TEST_CASE("the saddle-point system is solved with terms 1e6 times stiffer than the matrix, in few iterations") {
  const Model model = Resting().model;
  const std::vector<RankOneTerm> terms = random_terms(model, 1e4, 1e10);
  // 80: the multigrid sees less than a quarter of some motions, so that A0 has to be made smaller on the way
  const double stiffer = GENERATE(0., 80.);
  CAPTURE(stiffer);
  Resting resting(terms, stiffer);
  MatrixXd A = resting.matrix();
  for (const RankOneTerm& term : terms) A += dense_term(model, term) * dense_term(model, term).transpose();
  test::Random random(3);
  VectorXd b(A.rows());
  for (double& value : b) value = random.uniform(-1, 1);
  const Solved solution = solve_from_rest(model, b, {.tolerance = 1e-7}, resting.system);
  const VectorXd expected = A.ldlt().solve(b);
  CHECK((solution.x - expected).norm() <= 1e-4 * expected.norm());
  CHECK(solution.iterations <= (stiffer > 0 ? 130 : 60));
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const double product = dense_term(model, terms[t]).dot(expected);
    CHECK(std::abs(solution.products[Eigen::Index(t)] - product) <= 1e-3 * solution.products.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("forces that are added to a system are solved for with what solves before have left over") {
  const std::vector<RankOneTerm> terms = random_terms(Resting().model, 1e4, 1e10);
  Resting resting(terms);
  const Model& model = resting.model;
  test::Random random(3);
  VectorXd b(3 * model.num_nodes()), added(b.size());
  for (double& value : b) value = random.uniform(-1, 1);
  for (double& value : added) value = random.uniform(-1, 1);
  const VectorXd expected = solve_from_rest(model, b + added, {.tolerance = 1e-6}, resting.system).x;

  const Solved loose = solve_from_rest(model, b, {.tolerance = 0.3}, resting.system);
  CHECK(loose.started == 1);
  CHECK(loose.error <= 0.3);
  add_force(model, added, resting.system);
  const Solved fallen = solve_on(model, {.tolerance = 1e-6, .reduction = 0.1}, resting.system);
  CHECK(fallen.error > 1e-6);
  CHECK(fallen.error <= 0.1);
  const Solved whole = solve_on(model, {.tolerance = 1e-6}, resting.system);
  CHECK(whole.error <= 1e-6);
  CHECK((whole.x - expected).norm() <= 1e-4 * expected.norm());
  const Solved again = solve_on(model, {.tolerance = 1e-5}, resting.system);
  CHECK(again.iterations == 0);
  CHECK(again.x == whole.x);

  add_force(model, 1e-3 * added, resting.system);
  const Solved little = solve_on(model, {.tolerance = 0.1}, resting.system);
  CHECK(little.iterations == 1);  // small from the start, but the cycle that tells so is put to use
  CHECK(little.started <= 3e-3);
  CHECK(little.error < 0.5 * little.started);
}

namespace {

// linear iterations for a bar of 5 x 5 x 24 cells, or finer ones, whose terms all hold the strain along it
int bar_iterations(int finer, double tolerance, bool may_factor) {
  const Model model = make_model({test::make_block({5 * finer, 5 * finer, 24 * finer}, {0, 0, 0}, 0.1 / finer)}, {});
  MultigridSystem system = system_at_rest(model, strain_terms(model));
  if (!may_factor) leave_unfactored(system.bodies.front());
  test::Random random(5);
  VectorXd b(3 * model.num_nodes());
  for (double& value : b) value = random.uniform(-1, 1);
  return solve_from_rest(model, b, {.tolerance = tolerance}, system).iterations;
}

}  // namespace

TEST_CASE("terms of a bar that all hold the strain along it are solved for in few iterations, however fine it is") {
  const int coarse = bar_iterations(1, 1e-6, true), fine = bar_iterations(2, 1e-6, true);
  CAPTURE(coarse, fine);
  CHECK(coarse <= 60);
  CHECK(fine <= 60);
}

TEST_CASE("iterations do not stand still where a residual's own direction leads nowhere") {
  CHECK(bar_iterations(2, 3e-4, false) <= 85);  // 64; 103 where they take it all the same
}

TEST_CASE("coarse terms measure what the terms that they stand for measure together, of what is as smooth") {
  Resting resting(random_terms(Resting().model, 1e4, 1e6));
  BodyGrid& grid = resting.system.bodies.front();
  REQUIRE(grid.terms.levels.size() >= 2);
  const SaddlePointLevel &fine = grid.terms.levels[0], &coarse = grid.terms.levels[1];
  test::Random random(9);
  MultigridLevel &fine_grid = grid.multigrid.levels[0], &coarse_grid = grid.multigrid.levels[1];
  for (std::size_t slot = 0; slot < coarse_grid.lattice().num_slots(); ++slot)
    if (coarse_grid.matrix.diagonal[slot] > 0)
      set_node_value(int(slot), random.vector(1).cast<float>().eval(), coarse_grid.x[0]);
  std::fill(fine_grid.x[0].begin(), fine_grid.x[0].end(), 0.f);
  prolong(grid.multigrid, 0, coarse_grid.x[0], 0);
  VectorXd products(Eigen::Index(fine.terms.vectors.size())), measured(Eigen::Index(coarse.terms.vectors.size()));
  multiply(fine.terms, fine_grid.x[0], products);
  multiply(coarse.terms, coarse_grid.x[0], measured);
  VectorXd sums = VectorXd::Zero(measured.size());
  for (Eigen::Index t = 0; t < products.size(); ++t) sums[fine.parents[t]] += products[t];
  CHECK((measured - sums).norm() <= 1e-5 * sums.norm());
  CHECK(coarse.own.sum() == float(fine.terms.vectors.size()));
}

TEST_CASE("terms of a group become one in a coarse cell, and the system is solved with them as with others") {
  const Model model = Resting().model;
  std::vector<RankOneTerm> terms = random_terms(model, 1e4, 1e6);
  test::Random random(13);
  for (int hex = 0; hex < int(model.num_hexes()); hex += 2)
    for (const int group : {1, 3, 1}) {
      RankOneTerm term{hex, Vector24d::Zero(), 0, group};
      for (int n = 0; n < 8; ++n) term.vector[3 * n + group % 3] = random.uniform(0, 1e3);
      terms.push_back(term);
    }
  Resting resting(terms);
  const SaddlePointLevel& coarse = resting.system.bodies.front().terms.levels[1];
  for (const RankOneTerms::Hex& hex : coarse.terms.hexes) {
    std::array<int, most_term_groups + 1> counts{};
    for (int t = hex.first; t < hex.end; ++t) ++counts[std::size_t(coarse.terms.groups[std::size_t(t)])];
    CHECK(counts[0] <= 1);
    CHECK(counts == std::array{counts[0], 1, 0, 1});
  }
  CHECK(coarse.own.sum() == float(terms.size()));
  MatrixXd A = resting.matrix();
  for (const RankOneTerm& term : terms) A += dense_term(model, term) * dense_term(model, term).transpose();
  const VectorXd b = VectorXd::LinSpaced(A.rows(), -1, 2), expected = A.ldlt().solve(b);
  const Solved solution = solve_from_rest(model, b, {.tolerance = 1e-7}, resting.system);
  CHECK((solution.x - expected).norm() <= 1e-4 * expected.norm());
  CHECK(solution.iterations <= 60);
}

namespace {

// How blocks of 8 x 8 x 8 hexes at these places move, each under the same forces and with all strains along z held:
// a column for each, its nodes in the same order.
struct BlockMotions {
  MatrixXd columns;
  int iterations = 0;
};
BlockMotions motions_of_blocks(const std::vector<Vector3i>& places) {
  constexpr int edge = 8, num_nodes = (edge + 1) * (edge + 1) * (edge + 1);
  const Lattice block = make_box_lattice(Vector3i::Constant(edge), Vector3d::Zero(), Vector3d::Ones());
  Cells cells(block.num_hexes() * Eigen::Index(places.size()), 3);
  for (std::size_t i = 0; i < places.size(); ++i)
    cells.middleRows(block.num_hexes() * Eigen::Index(i), block.num_hexes()) =
        block.cells.rowwise() + places[i].transpose();
  Body body = test::make_block({edge, edge, edge}, {0, 0, 0}, 1);
  body.lattice = make_lattice(cells, Vector3d::Zero(), Vector3d::Ones());
  const Model model = make_model({body}, {});
  Eigen::MatrixXi nodes(num_nodes, Eigen::Index(places.size()));
  for (int node = 0; node < int(model.num_nodes()); ++node)
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vector3i within = model.rest_positions.row(node).transpose().cast<int>() - places[i];
      if (within.minCoeff() >= 0 && within.maxCoeff() <= edge)
        nodes(((edge + 1) * within[0] + within[1]) * (edge + 1) + within[2], Eigen::Index(i)) = node;
    }
  VectorXd b(3 * model.num_nodes());
  for (Eigen::Index i = 0; i < nodes.cols(); ++i)
    for (int n = 0; n < num_nodes; ++n) b.segment<3>(3 * nodes(n, i)) = Vector3d(n % 5 - 2, n % 7 - 3, n % 4 - 1);
  MultigridSystem system = system_at_rest(model, strain_terms(model));
  const Solved solution = solve_from_rest(model, b, {.tolerance = 1e-6}, system);
  BlockMotions motions{MatrixXd(3 * num_nodes, nodes.cols()), solution.iterations};
  for (Eigen::Index i = 0; i < nodes.cols(); ++i)
    for (int n = 0; n < num_nodes; ++n)
      motions.columns.col(i).segment<3>(3 * n) = solution.x.segment<3>(3 * nodes(n, i));
  return motions;
}

}  // namespace

TEST_CASE("terms of hexes that lie millions of cells apart are told from each other") {
  constexpr int far = 1 << 22;  // these cells, or coarse ones, are the same where a coordinate loses its highest bits
  const BlockMotions alone = motions_of_blocks({{0, 0, 0}}),
                     apart = motions_of_blocks(
                         {{0, 0, 0}, {far, 0, 0}, {0, far, 0}, {0, 0, far}, {far / 2, 2, 0}, {2, far / 2, 0}});
  for (const auto& motion : apart.columns.colwise())
    CHECK((motion - alone.columns).norm() <= 1e-4 * alone.columns.norm());
  CHECK(apart.iterations <= 2 * alone.iterations);  // 4 and 4
}

TEST_CASE("terms hold what they measure at their offsets") {
  const Model model = Resting().model;
  std::vector<RankOneTerm> terms = random_terms(model, 1e4, 1e6);
  Resting without(terms);
  test::Random random(11);
  VectorXd b = VectorXd::Ones(3 * model.num_nodes()), with_forces = b;
  for (RankOneTerm& term : terms) {
    term.offset = random.uniform(-1, 1);
    with_forces -= term.offset * dense_term(model, term);
  }
  Resting with(terms);
  const SaddlePointOptions options{.tolerance = 1e-7};
  const Solved held = solve_from_rest(model, b, options, with.system);
  const Solved pushed = solve_from_rest(model, with_forces, options, without.system);
  CHECK((held.x - pushed.x).norm() <= 1e-4 * pushed.x.norm());
  CHECK((held.products - pushed.products).norm() <= 1e-4 * pushed.products.norm());
}
