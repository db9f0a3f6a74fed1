// Multigrid-preconditioned conjugate gradients against the direct solver.
#include "core/linear/multigrid/multigrid.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/linear/direct/sparse_cholesky.h"
#include "core/linear/multigrid/chebyshev.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/conjugate_gradient.h"
#include "tests/support/hex_samples.h"
#include "tests/support/hex_systems.h"
#include "tests/support/matrix_product.h"

using namespace umax;
using test::HexSystem;
using test::HexSystemOptions;
using test::Random;

namespace {

struct Solution {
  VectorXd x;
  test::ConjugateGradientReport report;
};

Multigrid multigrid_of(const HexSystem& system, const MultigridOptions& options) {
  Multigrid multigrid = make_multigrid(system.bricks, system.shape.poisson, options);
  multigrid.levels.front().matrix = system.matrix<float>();
  set_up(multigrid);
  return multigrid;
}

Solution solve(const HexSystem& system, const VectorXd& b, double tolerance, const MultigridOptions& options) {
  Multigrid multigrid = multigrid_of(system, options);
  const HexMatrix<double> exact = system.matrix<double>();
  test::ConjugateGradientWorkspace workspace = test::make_workspace(multigrid);
  AlignedArray<double> bs(system.bricks.num_slots() * vector_components), xs(bs.size());
  to_bricks(system.node_slots, b, bs);
  Solution solution;
  solution.report = test::solve(multigrid, &exact, {.tolerance = tolerance}, bs, workspace, xs);
  from_bricks(system.node_slots, xs, solution.x);
  return solution;
}

struct Case {
  HexSystemOptions system;
  int most_iterations = 0;  // to 1e-8
  int degree = 2;
};

std::vector<Case> cases() {
  Random random(4);
  const auto block = test::box_cells({14, 14, 14});
  std::vector<double> contrast(100, 1);  // 10 % of 10, 1 % of 300
  std::fill_n(contrast.begin(), 10, 10);
  contrast[10] = 300;
  Cells islands(3, 3);
  islands << 0, 0, 0, 3, 3, 3, 3, 3, 4;
  Cells plates = test::box_cells({12, 16, 16});
  Cells thin(2 * 2 * 256, 3);  // two plates, two cells thick, with a gap
  int count = 0;
  for (int e = 0; e < plates.rows(); ++e)
    if (plates(e, 0) % 6 < 2) thin.row(count++) = plates.row(e);
  return {
      {{.name = "a single hex", .cells = test::box_cells({1, 1, 1}), .turn = 1}, 4},
      {{.name = "a block at rest", .cells = block, .fix_low_x = true}, 10},
      {{.name = "a bent block", .cells = block, .bend = 1.6, .fix_low_x = true}, 10},
      {{.name = "a free bent block of short time step", .cells = block, .inverse_time_squared = 4e6, .bend = 1.6}, 8},
      {{.name = "contrast 300", .cells = block, .bend = 1.6, .multipliers = contrast, .fix_low_x = true}, 40, 3},
      {{.name = "holes", .cells = test::with_holes(block, 0.15, random), .bend = 1, .fix_low_x = true}, 14},
      {{.name = "half holes", .cells = test::with_holes(block, 0.5, random), .bend = 1, .share_fixed = 0.01}, 40},
      {{.name = "thin plates", .cells = thin, .bend = 0.5}, 30},
      {{.name = "a rod", .cells = test::box_cells({96, 2, 2}), .bend = 1.6, .fix_low_x = true}, 20},
      {{.name = "islands", .cells = islands, .turn = 1}, 6},
      {{.name = "flat cells 1:10",
        .cells = test::box_cells({10, 10, 20}),
        .cell_size = {0.1, 0.1, 0.01},
        .bend = 0.5,
        .fix_low_x = true},
       30},
      {{.name = "flat cells 1:100",
        .cells = test::box_cells({10, 10, 20}),
        .cell_size = {0.1, 0.1, 0.001},
        .bend = 0.5,
        .fix_low_x = true},
       60},
      {{.name = "nearly incompressible", .cells = block, .poisson = 0.45, .bend = 1, .fix_low_x = true}, 20},
  };
}

}  // namespace

TEST_CASE("a multigrid without a factor has nothing undefined that a move would read", "[multigrid]") {
  Multigrid from, to;
  to = std::move(from);  // tools/test --sanitize fails here on what was never set
  CHECK(to.dense.is_definite);
}

TEST_CASE("multigrid gives the direct solver's solution in a bounded number of iterations") {
  for (const Case& c : cases()) {
    const HexSystem system = test::make_hex_system(c.system);
    Random random(8);
    VectorXd b = system.random_vector(random);
    for (Eigen::Index n = 0; n < b.size() / 3; ++n)
      b.segment<3>(3 * n) += system.fixed[n] ? Vector3d(Vector3d::Zero()) : Vector3d(0, -3, 1);
    SparseCholesky cholesky;
    REQUIRE(cholesky.factorize(system.assembled));
    MatrixXd expected = b;
    cholesky.solve(expected);
    const Solution solution = solve(system, b, 1e-10, {.degree = c.degree});
    const double residual = (test::multiply(system.assembled, solution.x) - b).norm() / b.norm();
    const int to_1e8 = solve(system, b, 1e-8, {.degree = c.degree}).report.iterations;
    INFO(c.system.name << ", " << system.lattice.num_hexes() << " hexes: " << to_1e8 << " iterations to 1e-8");
    CHECK(solution.report.converged);
    CHECK(solution.report.residual <= 1e-10);
    CHECK(residual < 2e-10);  // the assembled matrix rounds differently
    CHECK((solution.x - expected).norm() < 1e-8 * expected.norm());
    CHECK(to_1e8 <= c.most_iterations);
  }
}

TEST_CASE("Chebyshev's iteration leaves over what its polynomial says, inside the interval and outside") {
  constexpr double largest = 3, interval = 8;
  const double theta = largest * (1 + 1 / interval) / 2, delta = largest * (1 - 1 / interval) / 2;
  const auto polynomial = [](int n, double x) {  // T_n
    double before = 1, now = x;
    for (int i = 1; i < n; ++i) before = std::exchange(now, 2 * x * now - before);
    return n == 0 ? 1 : now;
  };
  for (const double eigenvalue : {0.1, largest / interval, 1.1, 2.7, largest}) {
    ChebyshevRecurrence<double> recurrence(largest, interval);
    double error = 1, d = recurrence.first_gain() * eigenvalue;
    for (int n = 1; n < 6; ++n) {
      error -= d;
      const double expected = polynomial(n, (theta - eigenvalue) / delta) / polynomial(n, theta / delta);
      CHECK(error == Approx(expected).margin(1e-12));
      const auto [momentum, gain] = recurrence.next();
      d = momentum * d + gain * eigenvalue * error;
    }
  }
}

TEST_CASE("the V-cycle is symmetric and positive definite") {
  for (const Case& c : cases()) {
    const HexSystem system = test::make_hex_system(c.system);
    Multigrid multigrid = multigrid_of(system, {.degree = c.degree});
    Random random(12);
    const VectorXd r[2] = {system.random_vector(random), system.random_vector(random)};
    VectorXd z[2];
    for (int i = 0; i < 2; ++i) {
      AlignedArray<float> bricks(system.bricks.num_slots() * vector_components);
      to_bricks(system.node_slots, r[i], bricks);
      double product = 0;
      from_bricks(system.node_slots, precondition(multigrid, bricks, product), z[i]);
      INFO(c.system.name);
      CHECK(std::abs(product - r[i].dot(z[i])) < 1e-5 * r[i].norm() * z[i].norm());
      CHECK(product > 0);
      for (std::size_t n = 0; n < system.fixed.size(); ++n)
        if (system.fixed[n]) CHECK(z[i].segment<3>(3 * Eigen::Index(n)).norm() == 0);
    }
    INFO(c.system.name);
    CHECK(std::abs(r[0].dot(z[1]) - r[1].dot(z[0])) < 3e-5 * r[0].norm() * z[1].norm());
  }
}

TEST_CASE("operators and multigrids may be moved, and outlive what they were made from") {
  const HexSystem system = test::make_hex_system(cases()[2].system);
  Random random(17);
  AlignedArray<float> r(system.bricks.num_slots() * vector_components), product(r.size()), expected_product(r.size());
  to_bricks(system.node_slots, system.random_vector(random), r);
  BrickLattice bricks = system.bricks;
  const HexOperator op = make_hex_operator(bricks, system.shape);
  apply(op, system.matrix<float>(), r, expected_product);
  bricks = {};
  apply(HexOperator(op), system.matrix<float>(), r, product);
  CHECK(std::equal(product.begin(), product.end(), expected_product.begin()));

  Multigrid multigrid = multigrid_of(system, {});
  double rz = 0, expected_rz = 0;
  VectorXd z, expected;
  from_bricks(system.node_slots, precondition(multigrid, r, expected_rz), expected);
  std::vector<MultigridLevel> elsewhere;
  for (MultigridLevel& level : multigrid.levels) elsewhere.push_back(std::move(level));
  Multigrid moved = std::move(multigrid);
  moved.levels = std::move(elsewhere);
  multigrid = {};
  from_bricks(system.node_slots, precondition(moved, r, rz), z);
  CHECK(rz == expected_rz);
  CHECK(z == expected);
}

TEST_CASE("a solution's bits do not depend on the number of threads") {
  for (const Case& c : cases()) {
    const HexSystem system = test::make_hex_system(c.system);
    Random random(13);
    const VectorXd b = system.random_vector(random);
    std::vector<Solution> solutions;
    for (const std::size_t threads : {1, 2, 3}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      solutions.push_back(solve(system, b, 1e-6, {.degree = c.degree}));
    }
    INFO(c.system.name);
    CHECK(solutions[0].x == solutions[1].x);
    CHECK(solutions[0].x == solutions[2].x);
    CHECK(solutions[0].report.iterations == solutions[2].report.iterations);
  }
}

TEST_CASE("solving single stiff hexes exactly reduces every error") {
  for (const std::vector<double>& multipliers :
       {std::vector<double>{1, 1, 1, 1, 1, 1, 1, 1, 1, 300}, std::vector<double>{1, 300}}) {
    const HexSystem system = test::make_hex_system({.name = "stiff hexes",
                                                    .cells = test::box_cells({9, 10, 17}),
                                                    .turn = 0.2,
                                                    .multipliers = multipliers,
                                                    .fix_low_x = true});
    const HexOperator op = make_hex_operator(system.bricks, system.shape);
    const StiffCellSmoother cells = make_stiff_cell_smoother(op, system.matrix<float>(), system.shape.stiffness, 30);
    REQUIRE(cells.nodes.size() > 10);

    // power iteration on the error's propagation 1 - L A, in the norm of A: its largest eigenvalue stays below 1
    Random random(15);
    VectorXd error = system.random_vector(random);
    double ratio = 0;
    for (int n = 0; n < 60; ++n) {
      const VectorXd r = test::multiply(system.assembled, error);
      AlignedArray<float> rs(system.bricks.num_slots() * vector_components), zs(rs.size());
      to_bricks(system.node_slots, r, rs);
      add_corrections(cells, rs, zs);
      VectorXd z;
      from_bricks(system.node_slots, zs, z);
      const VectorXd next = error - z;
      ratio = std::sqrt(next.dot(test::multiply(system.assembled, next)) / error.dot(r));
      CHECK(ratio < 1 + 1e-6);
      error = next / next.norm();
    }
  }
}

TEST_CASE("stored rows of stiff hexes do what sweeps over the lattice do") {
  const HexSystem system = test::make_hex_system({.name = "stiff hexes",
                                                  .cells = test::box_cells({9, 10, 17}),
                                                  .turn = 0.2,
                                                  .multipliers = {1, 1, 1, 1, 1, 1, 1, 1, 1, 300},
                                                  .fix_low_x = true});
  const HexOperator op = make_hex_operator(system.bricks, system.shape);
  const HexMatrix<float> matrix = system.matrix<float>();
  CHECK(make_stiff_cell_smoother(op, matrix, system.shape.stiffness, 30, 10).rows.empty());
  const StiffCellSmoother cells = make_stiff_cell_smoother(op, matrix, system.shape.stiffness, 30, 1000);
  REQUIRE(cells.rows.size() == cells.nodes.size());
  REQUIRE(cells.rows.size() > 10);

  Random random(16);
  const VectorXd given = system.random_vector(random);
  AlignedArray<float> r(system.bricks.num_slots() * vector_components), z(r.size()), rest(r.size());
  to_bricks(system.node_slots, given, r);
  const float between = 1e-6f;  // what stands for the V-cycle: a multiple of what is left
  add_corrections(cells, r, z);
  residual(op, matrix, r, z, rest);
  double product = 0;  // rest . z of the part in between
  for (std::size_t i = 0; i < z.size(); ++i) {
    z[i] += between * rest[i];
    product += double(rest[i]) * double(between * rest[i]);
  }
  AlignedArray<float> left(r.size());
  residual(op, matrix, r, z, left);
  add_corrections(cells, left, z);

  AlignedArray<float> local_rest(r.size()), local(r.size());
  std::copy(r.begin(), r.end(), local_rest.begin());
  const std::vector<StiffCellSmoother::Vector24f> before = correct_before(cells, r, local_rest);
  for (std::size_t i = 0; i < local.size(); ++i) local[i] = between * local_rest[i];
  const double gain = correct_after(cells, r, before, local);
  VectorXd expected_rest, expected, got_rest, got;
  from_bricks(system.node_slots, rest, expected_rest);
  from_bricks(system.node_slots, local_rest, got_rest);
  from_bricks(system.node_slots, z, expected);
  from_bricks(system.node_slots, local, got);
  CHECK((got_rest - expected_rest).norm() <= 1e-5 * expected_rest.norm());
  CHECK((got - expected).norm() <= 1e-5 * expected.norm());
  CHECK(product + gain == Approx(given.dot(got)).epsilon(1e-4));
}

TEST_CASE("a hex in an even cage is not solved for by itself") {
  const HexSystem system = test::make_hex_system(cases()[2].system);
  const HexOperator op = make_hex_operator(system.bricks, system.shape);
  CHECK(make_stiff_cell_smoother(op, system.matrix<float>(), system.shape.stiffness, 30).nodes.empty());
}

TEST_CASE("every instruction set solves the same system") {
  const HexSystem system = test::make_hex_system(cases()[5].system);
  Random random(14);
  const VectorXd b = system.random_vector(random);
  const Solution expected = solve(system, b, 1e-10, {.instruction_set = InstructionSet::portable});
  for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    const Solution solution = solve(system, b, 1e-10, {.instruction_set = set});
    CHECK((solution.x - expected.x).norm() < 1e-8 * expected.x.norm());
    CHECK(std::abs(solution.report.iterations - expected.report.iterations) <= 1);
  }
}

TEST_CASE("a system without load is solved at once by zero") {
  const HexSystem system = test::make_hex_system(cases()[1].system);
  const Solution solution = solve(system, VectorXd::Zero(3 * system.lattice.num_nodes()), 1e-6, {});
  CHECK(solution.report.converged);
  CHECK(solution.report.iterations == 0);
  CHECK(solution.x.norm() == 0);
}
