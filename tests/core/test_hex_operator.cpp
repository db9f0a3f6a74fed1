// The matrix-free operator against the assembled matrix.
#include "core/linear/bricks/hex_operator.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/element/elastic_energy.h"
#include "core/linear/direct/system_matrix.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/double_operator.h"
#include "tests/support/hex_samples.h"
#include "tests/support/hex_systems.h"
#include "tests/support/matrix_product.h"

using namespace umax;
using test::HexSystem;
using test::Random;

namespace {

const std::vector<InstructionSet> instruction_sets = {InstructionSet::portable, InstructionSet::avx2,
                                                      InstructionSet::avx512};

template <class T, class S>
VectorXd multiply_in_bricks(const HexSystem& system, const VectorXd& x, InstructionSet set, double* product = nullptr) {
  const HexOperator op = make_hex_operator(system.bricks, system.shape, set);
  const HexMatrix<S> matrix = system.matrix<S>();
  AlignedArray<T> in(system.bricks.num_slots() * vector_components), out(in.size());
  to_bricks(system.node_slots, x, in);
  using test::apply;  // in double; the library's own by its arguments
  const double xAx = apply(op, matrix, in, out);
  if (product) *product = xAx;
  VectorXd y;
  from_bricks(system.node_slots, out, y);
  return y;
}

}  // namespace

TEST_CASE("the matrix-free operator is the assembled matrix") {
  for (const HexSystem& system : test::hex_systems()) {
    Random random(5);
    const VectorXd x = system.random_vector(random), expected = test::multiply(system.assembled, x);
    for (const InstructionSet set : instruction_sets) {
      if (!is_supported(set)) continue;
      double product = 0;
      INFO(system.name << ", instruction set " << int(set));
      CHECK((multiply_in_bricks<double, double>(system, x, set, &product) - expected).norm() < 1e-12 * expected.norm());
      CHECK(std::abs(product - x.dot(expected)) < 1e-12 * x.norm() * expected.norm());
      CHECK((multiply_in_bricks<float, float>(system, x, set, &product) - expected).norm() < 1e-6 * expected.norm());
      CHECK(std::abs(product - x.dot(expected)) < 1e-5 * x.norm() * expected.norm());
      CHECK((multiply_in_bricks<double, float>(system, x, set) - expected).norm() < 1e-6 * expected.norm());
    }
  }
}

TEST_CASE("instruction sets give the same product to rounding") {
  for (const HexSystem& system : test::hex_systems()) {
    Random random(6);
    const VectorXd x = system.random_vector(random);
    const VectorXd expected = multiply_in_bricks<double, double>(system, x, InstructionSet::portable);
    for (const InstructionSet set : instruction_sets)
      if (is_supported(set))
        CHECK((multiply_in_bricks<double, double>(system, x, set) - expected).norm() < 1e-13 * expected.norm());
  }
}

TEST_CASE("the operator's bits do not depend on the number of threads") {
  for (const HexSystem& system : test::hex_systems()) {
    Random random(7);
    const VectorXd x = system.random_vector(random);
    std::vector<VectorXd> results;
    std::vector<double> products;
    for (const std::size_t threads : {1, 2, 3}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      double product = 0;
      results.push_back(multiply_in_bricks<float, float>(system, x, best_instruction_set(), &product));
      products.push_back(product);
      results.push_back(multiply_in_bricks<double, double>(system, x, best_instruction_set(), &product));
      products.push_back(product);
    }
    for (std::size_t i = 2; i < results.size(); ++i) {
      CHECK(results[i] == results[i - 2]);
      CHECK(products[i] == products[i - 2]);
    }
  }
}

TEST_CASE("the operator is symmetric and positive definite") {
  for (const HexSystem& system : test::hex_systems()) {
    Random random(8);
    const VectorXd x = system.random_vector(random), y = system.random_vector(random);
    const VectorXd Ax = multiply_in_bricks<double, double>(system, x, best_instruction_set());
    const VectorXd Ay = multiply_in_bricks<double, double>(system, y, best_instruction_set());
    CHECK(std::abs(x.dot(Ay) - y.dot(Ax)) < 1e-12 * x.norm() * Ay.norm());
    CHECK(x.dot(Ax) > 0);
  }
}

TEST_CASE("a residual and a Chebyshev step are what their formulas say") {
  for (const HexSystem& system : test::hex_systems()) {
    Random random(9);
    const VectorXd x = system.random_vector(random), b = system.random_vector(random);
    const VectorXd previous = system.random_vector(random);
    const VectorXd r = b - test::multiply(system.assembled, x);
    const HexOperator op = make_hex_operator(system.bricks, system.shape);
    const std::size_t size = system.bricks.num_slots() * vector_components;
    AlignedArray<double> xs(size), bs(size);
    AlignedArray<float> rs(size);
    to_bricks(system.node_slots, x, xs);
    to_bricks(system.node_slots, b, bs);
    const double squared = test::residual(op, system.matrix<double>(), bs, xs, rs);
    VectorXd result;
    from_bricks(system.node_slots, rs, result);
    CHECK((result - r).norm() < 1e-6 * r.norm());
    CHECK(std::abs(squared - r.squaredNorm()) < 1e-12 * r.squaredNorm());

    // with D^-1 = diag(1, 2, 3) and a coupling of x and z
    AlignedArray<float> inverse(system.bricks.num_slots() * inverse_components), xf(size), bf(size), out(size);
    Matrix3d D = Vector3d(1, 2, 3).asDiagonal();
    D(0, 2) = D(2, 0) = 0.5;
    for (std::size_t n = 0; n < system.node_slots.size(); ++n)
      for (int q = 0, row = 0, column = 0; q < inverse_components; ++q) {
        if (!system.fixed[n])
          inverse[slot_offset(system.node_slots[n], inverse_components) + q * brick_lanes] = float(D(row, column));
        if (++column == 3) column = ++row;
      }
    to_bricks(system.node_slots, x, xf);
    to_bricks(system.node_slots, b, bf);
    to_bricks(system.node_slots, previous, out);
    VectorXd expected = 0.75 * x + 0.25 * previous;
    for (Eigen::Index n = 0; n < expected.size() / 3; ++n) expected.segment<3>(3 * n) += 1e-6 * D * r.segment<3>(3 * n);
    const double bx = chebyshev(op, system.matrix<float>(), inverse, {0.75f, 0.25f, 1e-6f}, bf, xf, out);
    from_bricks(system.node_slots, out, result);
    CHECK((result - expected).norm() < 1e-5 * expected.norm());
    CHECK(std::abs(bx - b.dot(expected)) < 1e-5 * b.norm() * expected.norm());
  }
}

TEST_CASE("frames from positions are those of the elements") {
  for (const HexSystem& system : test::hex_systems()) {
    // stretched and turned, with noise, and one cell turned inside out
    Random random(10);
    const Matrix3d turn = random.rotation() * Vector3d(1.1, 0.9, 1.2).asDiagonal();
    const double size = system.lattice.cell_size.minCoeff();
    Points positions = system.lattice.rest_positions * turn.transpose();
    for (double& value : positions.reshaped()) value += random.uniform(-0.1, 0.1) * size;
    const Hexes& hexes = system.lattice.hexes;
    for (int n = 0; n < 4; ++n) positions.row(hexes(0, n)).swap(positions.row(hexes(0, 7 - n)));

    AlignedArray<double> xs(system.bricks.num_slots() * vector_components);
    AlignedArray<float> stiffness(system.bricks.num_slots());
    to_bricks(system.node_slots, positions.reshaped<Eigen::RowMajor>(), xs);
    for (std::size_t e = 0; e < system.cell_slots.size(); ++e)
      stiffness[std::size_t(system.cell_slots[e])] = float(system.stiffness[Eigen::Index(e)]);
    const HexOperator op = make_hex_operator(system.bricks, system.shape);
    HexMatrix<float> matrix = system.matrix<float>();
    set_frames(op, xs, stiffness, matrix);

    double worst = 0;
    for (Eigen::Index e = 0; e < hexes.rows(); ++e) {
      Matrix8x3d nodes;
      for (int n = 0; n < 8; ++n) nodes.row(n) = positions.row(hexes(e, n));
      const CorotatedHex hex = corotate(system.shape, RotationEstimate::centre, nodes);
      const Matrix3d found = frame_at(matrix.frames, system.cell_slots[e]) / std::sqrt(system.stiffness[e]);
      worst = std::max(worst, (found - hex.rotation).cwiseAbs().maxCoeff());
    }
    INFO(system.name);
    CHECK(worst < 1e-5);
  }
}
