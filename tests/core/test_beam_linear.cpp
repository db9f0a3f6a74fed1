// The element in an assembled body: patch test, linear beam, its frequencies, and its co-rotated static equilibrium.
// Reference values come from independent finite element codes (linear statics: CalculiX C3D8).
#include <Eigen/LU>

#include "core/element/elastic_energy.h"
#include "core/element/material.h"
#include "tests/support/catch.h"
#include "tests/support/eigenvalues.h"
#include "tests/support/hex_samples.h"
#include "tests/support/linear_assembly.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double young = 150e3, poisson = 0.3, density = 500, gravity = 9.81;

struct Beam {
  Lattice lattice = make_box_lattice({14, 2, 2}, {0, -0.06, -0.06}, {1.0 / 14, 0.06, 0.06});
  HexShape shape = make_hex_shape(nodes_of(lattice, lattice.rest_positions, 0), poisson);
  FreeDofs free = free_dofs(lattice, [](const Vector3d& x) { return x.x() < 1e-9; });
};

Vector3d mean_of_end_nodes(const Beam& beam, const VectorXd& displacement) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (Eigen::Index n = 0; n < beam.lattice.num_nodes(); ++n)
    if (beam.lattice.rest_positions(n, 0) > 1 - 1e-9) sum += displacement.segment<3>(3 * n), ++count;
  REQUIRE(count == 9);
  return sum / count;
}

// integral of rho g N: consistent nodal gravity of one hex, along -y
Vector24d element_weight(const HexShape& shape) {
  Vector24d weight = Vector24d::Zero();
  for (int q = 0; q < 8; ++q) {
    const Vector8d N = shape_functions(quadrature_points()[q]);
    for (int j = 0; j < 8; ++j) weight[3 * j + 1] -= density * gravity * shape.weights[q] * N[j];
  }
  return weight;
}

Matrix24d consistent_mass(const HexShape& shape) {
  Matrix24d mass = Matrix24d::Zero();
  for (int q = 0; q < 8; ++q) {
    const Vector8d N = shape_functions(quadrature_points()[q]);
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j)
        mass.block<3, 3>(3 * i, 3 * j).diagonal().array() += density * shape.weights[q] * N[i] * N[j];
  }
  return mass;
}

Matrix24d lumped_mass(const HexShape& shape) {
  return density * shape.volume / 8 * Matrix24d::Identity();
}

// the lowest six natural frequencies [Hz]
Eigen::Matrix<double, 6, 1> frequencies(const Beam& beam, const Matrix24d& element_mass) {
  const auto whole = [&](const Matrix24d& element) {
    return MatrixXd(free_columns(assemble(beam.lattice, beam.free, [&](Eigen::Index) { return element; }), beam.free));
  };
  return generalized_eigenvalues(whole(young * beam.shape.stiffness), whole(element_mass)).head<6>().cwiseSqrt() /
         (2 * 3.14159265358979323846);
}

enum class Force { warped, exact };

struct Linearised {
  double energy = 0;  // [J] elastic, minus the work of the load
  VectorXd residual;  // [N] free degrees of freedom
};

// Newton with the given force and its matrix on the beam under a share of its weight; displacement is start and result.
class BeamEquilibrium {
 public:
  BeamEquilibrium(const Beam& beam, Force force) : beam_(beam), force_(force) {
    const Vector24d weight = element_weight(beam.shape);
    load_ = assemble_vector(beam.lattice, [&](Eigen::Index) { return weight; });
  }

  // exact: Newton for the minimum of the energy, with the warped matrix where the Hessian is indefinite and with a line
  // search. warped: the same matrix and full steps from a start close by; it has no energy, and its own warped matrix
  // lacks the stiffness that comes with the turning of the hexes: with that one the steps diverge on this slender beam.
  double solve(double share, VectorXd& displacement) const {
    Linearised now = linearise(share, displacement);
    for (int k = 0; k < 200 && now.residual.norm() > 1e-11; ++k) {
      Eigen::SimplicialLDLT<SparseMatrix> factor(tangent(displacement, Force::exact));
      if (factor.vectorD().minCoeff() <= 0) factor.compute(tangent(displacement, Force::warped));
      const VectorXd step = -factor.solve(now.residual);
      const VectorXd direction = extend_by_zero(step, beam_.free);
      const double slope = step.dot(now.residual);
      double length = 1;
      Linearised next = linearise(share, displacement + direction);
      while (force_ == Force::exact && length > 1e-6 && next.energy > now.energy + 1e-4 * length * slope + 1e-13) {
        length /= 2;
        next = linearise(share, displacement + length * direction);
      }
      displacement += length * direction;
      now = std::move(next);
    }
    return now.residual.norm();
  }

 private:
  CorotatedHex corotated(const VectorXd& displacement, Eigen::Index e) const {
    const Points positions =
        beam_.lattice.rest_positions + Eigen::Map<const Points>(displacement.data(), beam_.lattice.num_nodes(), 3);
    return corotate(beam_.shape, RotationEstimate::centre, nodes_of(beam_.lattice, positions, e));
  }
  const Matrix8x3d& h() const { return beam_.shape.rotation_gradients[int(RotationEstimate::centre)]; }

  Linearised linearise(double share, const VectorXd& displacement) const {
    Linearised result;
    const VectorXd force = assemble_vector(beam_.lattice, [&](Eigen::Index e) {
      const CorotatedHex hex = corotated(displacement, e);
      result.energy += elastic_energy(beam_.shape.stiffness, young, hex);
      return force_ == Force::exact ? exact_gradient(beam_.shape.stiffness, young, h(), hex)
                                    : warped_gradient(beam_.shape.stiffness, young, hex);
    });
    result.energy -= share * load_.dot(displacement);
    result.residual = restrict_to_free(force - share * load_, beam_.free);
    return result;
  }

  SparseMatrix tangent(const VectorXd& displacement, Force force) const {
    const SparseMatrix rows = assemble(beam_.lattice, beam_.free, [&](Eigen::Index e) {
      const CorotatedHex hex = corotated(displacement, e);
      return force == Force::exact ? exact_hessian(beam_.shape.stiffness, young, h(), hex)
                                   : warped_hessian(beam_.shape.stiffness, young, hex);
    });
    return free_columns(rows, beam_.free);
  }

  const Beam& beam_;
  Force force_;
  VectorXd load_;
};

}  // namespace

TEST_CASE("patch test: a linear field on the boundary is met exactly inside, on regular and irregular hexes") {
  Lattice lattice = make_box_lattice({3, 3, 3}, {0.1, -0.2, 0}, {0.3, 0.2, 0.5});
  const Vector3d low(0.1, -0.2, 0), high(1.0, 0.4, 1.5);
  const auto on_boundary = [&](const Vector3d& x) {
    return (x - low).cwiseAbs().minCoeff() < 1e-9 || (x - high).cwiseAbs().minCoeff() < 1e-9;
  };
  const bool irregular = GENERATE(false, true);
  Random random(1);
  for (Eigen::Index n = 0; irregular && n < lattice.num_nodes(); ++n)
    if (!on_boundary(lattice.rest_positions.row(n))) lattice.rest_positions.row(n) += random.vector(0.04).transpose();
  const FreeDofs free = free_dofs(lattice, on_boundary);
  REQUIRE(free.count == 24);

  Matrix3d A;
  A << 0.02, 0.01, -0.015, 0.01, -0.03, 0.005, -0.015, 0.005, 0.01;
  const Points field = lattice.rest_positions * A;  // symmetric
  const VectorXd exact = Eigen::Map<const VectorXd>(field.data(), field.size());

  std::vector<HexShape> shapes;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    shapes.push_back(make_hex_shape(nodes_of(lattice, lattice.rest_positions, e), poisson));
  const SparseMatrix rows =
      assemble(lattice, free, [&](Eigen::Index e) { return Matrix24d(young * shapes[e].stiffness); });
  VectorXd boundary = exact;
  for (Eigen::Index i = 0; i < boundary.size(); ++i)
    if (free.index[i] >= 0) boundary[i] = 0;
  const Eigen::SimplicialLDLT<SparseMatrix> factor(free_columns(rows, free));
  const VectorXd u = boundary + extend_by_zero(factor.solve(-(rows * boundary)), free);
  CHECK((u - exact).cwiseAbs().maxCoeff() < 1e-12 * exact.cwiseAbs().maxCoeff());

  // stresses at every Gauss point
  const Moduli m = moduli(young, poisson);
  const Matrix3d stress = m.E2 * A.trace() * Matrix3d::Identity() + 2 * m.E3 * A;
  const Points solved = Eigen::Map<const Points>(u.data(), lattice.num_nodes(), 3);
  double worst = 0;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    for (const Matrix8x3d& gradients : shapes[e].gradients) {
      const Matrix3d gradient = nodes_of(lattice, solved, e).transpose() * gradients;
      const Matrix3d found = m.E2 * gradient.trace() * Matrix3d::Identity() + m.E3 * (gradient + gradient.transpose());
      worst = std::max(worst, (found - stress).cwiseAbs().maxCoeff());
    }
  CHECK(worst < 1e-12 * stress.cwiseAbs().maxCoeff());
}

TEST_CASE("the linear beam sags by the value of an independent finite element code") {
  const Beam beam;
  const SparseMatrix K = free_columns(
      assemble(beam.lattice, beam.free, [&](Eigen::Index) { return Matrix24d(young * beam.shape.stiffness); }),
      beam.free);
  const Vector24d weight = element_weight(beam.shape);
  CHECK(weight.sum() == Approx(-density * gravity * beam.shape.volume).epsilon(1e-14));
  const VectorXd load =
      restrict_to_free(assemble_vector(beam.lattice, [&](Eigen::Index) { return weight; }), beam.free);
  const Eigen::SimplicialLDLT<SparseMatrix> factor(K);
  const VectorXd u = factor.solve(load);
  CHECK(mean_of_end_nodes(beam, extend_by_zero(u, beam.free)).y() == Approx(-2.878716).epsilon(1e-6));
  CHECK(0.5 * u.dot(K * u) == Approx(40.86424).epsilon(1e-6));
}

TEST_CASE("the beam's natural frequencies are those of an independent finite element code") {
  // the section is square: two bending pairs, then torsion, then the axial mode
  const Beam beam;
  const auto consistent = frequencies(beam, consistent_mass(beam.shape));
  const double expected_consistent[] = {0.364068, 0.364068, 2.165894, 2.165894, 2.686840, 4.364874};
  for (int i = 0; i < 6; ++i) CHECK(consistent[i] == Approx(expected_consistent[i]).epsilon(1e-6));

  const auto lumped = frequencies(beam, lumped_mass(beam.shape));
  const double expected_lumped[] = {0.362863, 0.362863, 2.120529, 2.120529, 2.191495, 4.359676};
  for (int i = 0; i < 6; ++i) CHECK(lumped[i] == Approx(expected_lumped[i]).epsilon(1e-6));
}

TEST_CASE("the co-rotated beam hangs in the static equilibrium of an independent code") {
  const Beam beam;
  VectorXd displacement = VectorXd::Zero(3 * beam.lattice.num_nodes());

  const BeamEquilibrium exact(beam, Force::exact);
  for (const double share : {0.1, 0.25, 0.5, 0.75}) exact.solve(share, displacement);
  CHECK(exact.solve(1, displacement) < 1e-9);  // [N] of a weight of 70.6 N
  const Vector3d exact_end = mean_of_end_nodes(beam, displacement);
  CHECK((exact_end - Vector3d(-0.594818, -0.868758, 0)).cwiseAbs().maxCoeff() < 1e-6);

  const BeamEquilibrium warped(beam, Force::warped);
  CHECK(warped.solve(1, displacement) < 1e-9);
  const Vector3d warped_end = mean_of_end_nodes(beam, displacement);
  CHECK((warped_end - Vector3d(-0.595051, -0.868893, 0)).cwiseAbs().maxCoeff() < 1e-6);
}
