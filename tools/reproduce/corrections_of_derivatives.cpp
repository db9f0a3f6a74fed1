// [PPO13] Eq. 15 to 18, Sect. 3.3 and 4.2: derivatives of the energy against finite differences, and the rotation.
#include <algorithm>
#include <array>
#include <limits>

#include "core/base/finite_differences.h"
#include "core/element/energy_limit.h"
#include "tools/reproduce/correction_samples.h"
#include "tools/reproduce/printed_equations.h"

namespace umax {
namespace {

using printed::Derivatives;
using printed::ShearModulus;

constexpr double limit = 2.0;  // [J] any

CorotatedHex corotated(const SampleHex& hex, RotationEstimate estimate, const Matrix8x3d& x) {
  return corotate(hex.shape, estimate, x);
}

Matrix3d held_rotation(const SampleHex& hex) {
  return corotated(hex, RotationEstimate::centre, hex.positions).rotation;
}

/// dU/dx [N] of Eq. 13 and 16 by finite differences, with R held.
Vector24d difference_of_equation_13(const SampleHex& hex, const Matrix3d& R) {
  return exact_difference(hex, [&](const Matrix8x3d& x) { return printed::equation_13(hex.shape, hex.moduli, R, x); });
}

/// Eq. 17 with one of its misprints, and with none.
ErrorPair equation_17_errors(const SampleHex& hex, ShearModulus shear, Derivatives derivatives) {
  const Matrix3d R = held_rotation(hex);
  const Vector24d difference = difference_of_equation_13(hex, R);
  const auto error = [&](ShearModulus modulus, Derivatives h) {
    return relative_error(printed::equation_17(hex.shape, hex.moduli, R, hex.positions, modulus, h), difference);
  };
  return {error(shear, derivatives), error(ShearModulus::E3, Derivatives::material)};
}

Correction sign_row() {
  const Correction row{.equation = "15",
                       .printed = "∂C/∂xⱼ = −det F / U_max Σ_q w_q ∂e/∂xⱼ",
                       .corrected = "the same: it is right",
                       .measure = "|∂C/∂x − finite differences| / |finite differences| of C, R held",
                       .remark = "With the corrected Eq. 17. A wrong sign would show as 2.",
                       .test = "[PPO13] Eq. 15 has the right sign"};
  return measured(row, sample_hexes(), [](const SampleHex& hex) {
    const CorotatedHex corotated_hex = corotated(hex, RotationEstimate::centre, hex.positions);
    const Matrix3d& R = corotated_hex.rotation;
    const Vector24d difference = exact_difference(
        hex, [&](const Matrix8x3d& x) { return 1 - printed::equation_13(hex.shape, hex.moduli, R, x) / limit; });
    const Vector24d sum =
        printed::equation_17(hex.shape, hex.moduli, R, hex.positions, ShearModulus::E3, Derivatives::material);
    const Vector24d core = energy_limit_jacobian(hex.shape, EnergyMeasure::paper, LimitJacobian::fixed_rotation,
                                                 RotationEstimate::centre, hex.young, limit, corotated_hex);
    return ErrorPair{relative_error(printed::equation_15(sum, limit), difference), relative_error(core, difference)};
  });
}

Correction equation_17_row(const std::string& printed, const std::string& corrected, const std::string& remark,
                           const std::string& test) {
  return {.equation = "17",
          .printed = printed,
          .corrected = corrected,
          .measure = "|∂U/∂x − finite differences| / |finite differences| of Eq. 13 and 16, R held",
          .remark = remark,
          .test = test};
}

Correction shear_modulus_row() {
  return measured(
      equation_17_row("∂eᵢₖ/∂xⱼ = E₂ (uᵢₖ + uₖᵢ)(hⱼₖ rᵢ + hⱼᵢ rₖ)", "E₃ in place of E₂",
                      "E₂ equals E₃ at ν = ¼; at ν = 0.3 it is half as large again.",
                      "[PPO13] Eq. 17 is the gradient with E3 and H F^-1, and wrong with the printed E2 or with H"),
      sample_hexes(),
      [](const SampleHex& hex) { return equation_17_errors(hex, ShearModulus::E2, Derivatives::material); });
}

Correction natural_derivatives_row() {
  return measured(
      equation_17_row("hⱼᵢ: an element of H = ∂N/∂s", "hⱼᵢ: an element of H F⁻¹ = ∂N/∂X",
                      "Off by half the edge in metres: no error for a cube of 2 m, 96 to 97 % for the beam's cells.",
                      "[PPO13] Eq. 9 and 17 of H are right for a cube of 2 m only"),
      sample_hexes(),
      [](const SampleHex& hex) { return equation_17_errors(hex, ShearModulus::E3, Derivatives::natural); });
}

Correction discarded_rotation_row(EnergyMeasure measure, RotationEstimate estimate, const std::string& of) {
  const Correction row{.equation = "17",
                       .printed = "∂U/∂x with the change of R discarded",
                       .corrected = "∂U/∂xⱼ = R (gⱼ − p × hⱼ), p = D⁻¹ Σ yⱼ × gⱼ, D = tr(S) I − S",
                       .measure = "|∂U/∂x − finite differences| / |finite differences|, R moving: " + of,
                       .remark = "What is discarded is a net torque, which no elastic force has.",
                       .test = "the exact gradient matches finite differences of the energy to second order"};
  return measured(row, sample_hexes(), [=](const SampleHex& hex) {
    const Matrix24d& K = measured_stiffness(hex.shape, measure);
    const Vector24d difference = fine_difference(
        hex, [&](const Matrix8x3d& x) { return elastic_energy(K, hex.young, corotated(hex, estimate, x)); });
    const CorotatedHex now = corotated(hex, estimate, hex.positions);
    const Matrix8x3d& h = hex.shape.rotation_gradients[int(estimate)];
    return ErrorPair{relative_error(warped_gradient(K, hex.young, now), difference),
                     relative_error(exact_gradient(K, hex.young, h, now), difference)};
  });
}

Correction warped_force_row() {
  const Correction row{
      .equation = "sect. 4.2",
      .printed = "the warped force R K u is only an approximation of ∂U/∂x with R held",
      .corrected = "with U = ½ ∫ σ:ε it is that derivative: one vector",
      .measure = "|R K u − finite differences| / |finite differences|, R held: of Eq. 16's energy; of ½ σ:ε",
      .remark = "What the paper compares in sect. 6.2 are two energies, not two derivatives.",
      .test = "with the true energy the rotation-fixed and the warped jacobian are one, with the paper's they differ"};
  return measured(row, sample_hexes(), [](const SampleHex& hex) {
    const CorotatedHex now = corotated(hex, RotationEstimate::centre, hex.positions);
    const Vector24d warped = warped_gradient(hex.shape.stiffness, hex.young, now);
    const Vector24d true_energy = exact_difference(hex, [&](const Matrix8x3d& x) {
      CorotatedHex held = now;
      const Matrix8x3d u = (x.rowwise() - x.colwise().mean()) * now.rotation - hex.shape.rest_nodes;
      held.displacement = Eigen::Map<const Vector24d>(u.data());
      return elastic_energy(hex.shape.stiffness, hex.young, held);
    });
    return ErrorPair{relative_error(warped, difference_of_equation_13(hex, now.rotation)),
                     relative_error(warped, true_energy)};
  });
}

/// The 48 rotations and reflections that map a cube to itself.
std::vector<Matrix3d> cube_symmetries() {
  std::vector<Matrix3d> symmetries;
  std::array<int, 3> axes{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d Q = Matrix3d::Zero();
      for (int i = 0; i < 3; ++i) Q(i, axes[i]) = signs >> i & 1 ? -1 : 1;
      symmetries.push_back(Q);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  return symmetries;
}

/// The same deformed cube with its nodes numbered from another corner and along other axes.
Matrix8x3d renumbered(const Matrix8x3d& positions, const Matrix3d& Q) {
  Matrix8x3d x;
  for (int n = 0; n < 8; ++n) {
    const Vector3d corner = Q * Vector3d(n & 4 ? 1 : -1, n & 2 ? 1 : -1, n & 1 ? 1 : -1);
    x.row((corner[0] > 0) << 2 | (corner[1] > 0) << 1 | (corner[2] > 0)) =
        (Q * positions.row(n).transpose()).transpose();
  }
  return x;
}

/// Largest over smallest energy of one shape in its 48 positions in the lattice, less 1.
double orientation_dependence(const SampleHex& cube, RotationEstimate estimate) {
  double least = std::numeric_limits<double>::max(), most = 0;
  for (const Matrix3d& Q : cube_symmetries()) {
    const double energy =
        elastic_energy(cube.shape.stiffness, cube.young, corotated(cube, estimate, renumbered(cube.positions, Q)));
    least = std::min(least, energy);
    most = std::max(most, energy);
  }
  return most / least - 1;
}

Correction tetrahedron_row(const std::string& printed, RotationEstimate estimate, const std::string& remark) {
  const Correction row{.equation = "sect. 3.3",
                       .printed = printed,
                       .corrected = "R from the deformation gradient at the cell's centre",
                       .measure = "largest / least energy − 1 of one deformed cube under the 48 symmetries of the cube",
                       .remark = remark,
                       .test = "only the centre's rotation gives a cube one energy under all its symmetries"};
  return measured(row, sample_hexes({Vector3d::Constant(0.163)}), [=](const SampleHex& hex) {
    return ErrorPair{orientation_dependence(hex, estimate), orientation_dependence(hex, RotationEstimate::centre)};
  });
}

}  // namespace

void add_derivative_corrections(std::vector<Correction>& rows) {
  rows.push_back(sign_row());
  rows.push_back(shear_modulus_row());
  rows.push_back(natural_derivatives_row());
  rows.push_back(
      discarded_rotation_row(EnergyMeasure::true_energy, RotationEstimate::centre, "½ σ:ε, R from the centre"));
  rows.push_back(discarded_rotation_row(EnergyMeasure::paper, RotationEstimate::kuhn,
                                        "Eq. 16, R from a tetrahedron of the paper's cut"));
  rows.push_back(warped_force_row());
  rows.push_back(tetrahedron_row("R from the innermost tetrahedron of the Coxeter-Freudenthal-Kuhn cut",
                                 RotationEstimate::kuhn,
                                 "There is none: all six share the main diagonal. Here: one of the six."));
  rows.push_back(tetrahedron_row("(the inner tetrahedron of the cut into five)", RotationEstimate::tetrahedron,
                                 "What the sentence may have meant."));
}

}  // namespace umax
