// [PPO13] Eq. 6, 9 and 12 to 16: deformation gradient, stiffness and energy, against closed forms of uniform
// deformations.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/finite_differences.h"
#include "tools/reproduce/correction_samples.h"
#include "tools/reproduce/printed_equations.h"

namespace umax {
namespace {

double elastic_energy_of(const SampleHex& hex, const Matrix24d& K, const Matrix8x3d& x) {
  return elastic_energy(K, hex.young, corotate(hex.shape, RotationEstimate::centre, x));
}

/// |U / U_closed - 1| of the energies that two stiffness matrices (unit Young's modulus) give to a uniform strain.
ErrorPair energy_errors(const SampleHex& hex, const Matrix24d& printed, const Matrix3d& strain) {
  const Matrix8x3d x = strained(hex, strain);
  const double exact = closed_form_energy(hex, strain);
  return {std::abs(elastic_energy_of(hex, printed, x) / exact - 1),
          std::abs(elastic_energy_of(hex, hex.shape.stiffness, x) / exact - 1)};
}

Correction deformation_gradient_row() {
  const std::vector<SampleHex> samples = sample_hexes();
  const Vector3d point = quadrature_points()[0];
  double condition = 0;
  for (const SampleHex& hex : samples)
    condition = std::max(condition, printed::equation_6_reciprocal_condition(hex.shape.rest_nodes, point));
  const Correction row{
      .equation = "6",
      .printed = "G = Σₙ xₙ ∂Nₙ/∂s (Xₙ ∂Nₙ/∂s)⁻¹: the inverse of each term",
      .corrected = "G = (Σₙ xₙ ∂Nₙ/∂s) (Σₙ Xₙ ∂Nₙ/∂s)⁻¹: the inverse of the sum",
      .measure = "|G − A| / |A| under the affine map A",
      .remark = fmt::format("The printed matrices have rank one and no inverse (reciprocal condition at most {:.0e}); "
                            "the number is that of their Moore-Penrose inverses, and it moves with the origin of X.",
                            condition),
      .test = "[PPO13] Eq. 6 needs the inverse of the sum: as printed it inverts matrices of rank one"};
  return measured(row, samples, [&](const SampleHex& hex) {
    const Matrix3d A = hex.pose * (Matrix3d::Identity() + hex.strain);
    const Matrix8x3d x = strained(hex, hex.strain);
    return ErrorPair{relative_error(printed::equation_6(hex.shape.rest_nodes, x, point), A),
                     relative_error(Matrix3d(x.transpose() * hex.shape.gradients[0]), A)};
  });
}

Correction shear_rows_row() {
  const Correction row{.equation = "9",
                       .printed = "B is 3 × 24: (diag(∂N₁/∂s) … diag(∂N₈/∂s))",
                       .corrected = "B is 6 × 24: three more rows, for the shear strains",
                       .measure = "|U / U_closed − 1| of a pure shear along the cell's axes",
                       .remark = "The printed matrix sees no shear at all. (Here with the right derivatives, H F⁻¹.)",
                       .test = "[PPO13] Eq. 9 needs a 6 x 24 strain matrix: the printed diagonal one sees no shear"};
  return measured(row, sample_hexes(), [](const SampleHex& hex) {
    Matrix3d shear = Matrix3d::Zero();
    shear(0, 1) = shear(1, 0) = 0.1;
    return energy_errors(hex, printed::equation_9(hex.shape, printed::Derivatives::material), shear);
  });
}

Correction material_derivatives_row() {
  const Correction row{.equation = "9",
                       .printed = "B of the natural derivatives H = ∂N/∂s",
                       .corrected = "B of the material derivatives H F⁻¹ = ∂N/∂X",
                       .measure = "|U / U_closed − 1| of a uniform strain",
                       .remark =
                           "Off by the square of half the edge in metres: no error for a cube of 2 m, 99.9 % for "
                           "the beam's cells. (Here with all six rows.)",
                       .test = "[PPO13] Eq. 9 and 17 of H are right for a cube of 2 m only"};
  return measured(row, sample_hexes(), [](const SampleHex& hex) {
    return energy_errors(hex, printed::equation_9_with_shear(hex.shape), hex.strain);
  });
}

Matrix3d uniaxial(const Vector3d& direction, double poisson) {
  const Vector3d d = direction.normalized();
  return 0.1 * (1 + poisson) * d * d.transpose() - 0.1 * poisson * Matrix3d::Identity();
}

ErrorPair density_errors(const SampleHex& hex, const Matrix3d& strain) {
  const Matrix8x3d x = strained(hex, strain);
  const double exact = closed_form_energy(hex, strain);
  return {std::abs(printed::equation_13(hex.shape, hex.moduli, hex.pose, x) / exact - 1),
          std::abs(elastic_energy_of(hex, hex.shape.stiffness, x) / exact - 1)};
}

Correction energy_row(const std::string& deformation, const std::string& remark) {
  return {.equation = "13, 16",
          .printed = "e = Σᵢ uᵢᵢ (αᵢ u₁₁ + βᵢ u₂₂ + γᵢ u₃₃) + Σ ½ E₃ (uᵢₖ + uₖᵢ)²",
          .corrected = "e = ½ σ:ε: the first sum halved",
          .measure = "|U / U_closed − 1|, U_closed = ½ σ:ε V: " + deformation,
          .remark = remark,
          .test =
              "the paper's energy depends on how the lattice lies: the same shear costs twice or once the true "
              "energy"};
}

void add_energy_rows(std::vector<Correction>& rows) {
  struct Deformation {
    std::string name, remark;
    std::function<Matrix3d(const SampleHex&)> strain;
  };
  const Matrix3d shear = Vector3d(0.1, -0.1, 0).asDiagonal();
  const Matrix3d turn = Eigen::AngleAxisd(0.25 * std::numbers::pi, Vector3d::UnitZ()).toRotationMatrix();
  const auto pull = [](const Vector3d& d) {
    return [d](const SampleHex& hex) { return uniaxial(d, hex.shape.poisson); };
  };
  const std::vector<Deformation> deformations{
      {"uniaxial stretch along [100]", "Twice the energy: U_max = ½ Y s² V stands for a stretch of s/√2 only.",
       pull({1, 0, 0})},
      {"uniaxial stretch along [110]", "Too much by 1 − 2μ Σ εᵢₖ² / e: the shear parts are counted right.",
       pull({1, 1, 0})},
      {"uniaxial stretch along [111]", "The same material, pulled as far: only the lattice lies otherwise.",
       pull({1, 1, 1})},
      {"pure shear, principal axes along the cell's", "Twice the energy …",
       [=](const SampleHex&) -> const Matrix3d& { return shear; }},
      {"the same shear turned by 45°", "… or once, as the cell lies: the printed energy is not isotropic.",
       [=](const SampleHex&) -> Matrix3d { return turn * shear * turn.transpose(); }},
      {"any uniform strain", "Always between once and twice the true energy.",
       [](const SampleHex& hex) { return hex.strain; }}};
  for (const Deformation& deformation : deformations)
    rows.push_back(measured(energy_row(deformation.name, deformation.remark), sample_hexes(),
                            [&](const SampleHex& hex) { return density_errors(hex, deformation.strain(hex)); }));
}

}  // namespace

void add_energy_corrections(std::vector<Correction>& rows) {
  rows.push_back(deformation_gradient_row());
  rows.push_back(shear_rows_row());
  rows.push_back(material_derivatives_row());
  add_energy_rows(rows);
}

}  // namespace umax
