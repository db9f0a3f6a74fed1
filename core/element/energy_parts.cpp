#include "core/element/energy_parts.h"

#include <cmath>
#include <limits>

#include "core/element/material.h"

namespace umax {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

// E' of the part for unit Young's modulus, in the order and with the engineering shear of elasticity_matrix()
Matrix6d part_elasticity(EnergyPart part, double poisson, const Vector3d& f) {
  Matrix6d volumetric = Matrix6d::Zero();
  volumetric.topLeftCorner<3, 3>().setConstant(1 / (3 * (1 - 2 * poisson)));
  switch (part) {
    case EnergyPart::whole:
      break;
    case EnergyPart::volumetric:
      return volumetric;
    case EnergyPart::deviatoric:
      return elasticity_matrix(1, poisson) - volumetric;
    case EnergyPart::fibre: {
      Vector6d along;  // f.eps f = along . eps
      along << f.x() * f.x(), f.y() * f.y(), f.z() * f.z(), f.y() * f.z(), f.x() * f.z(), f.x() * f.y();
      return along * along.transpose();
    }
  }
  return elasticity_matrix(1, poisson);
}

}  // namespace

const char* limit_name(EnergyPart part) {
  constexpr const char* names[num_energy_parts] = {"limit", "limit.volumetric", "limit.deviatoric", "limit.fibre"};
  return names[int(part)];
}

double uniaxial_share(EnergyPart part, double poisson) {
  if (part == EnergyPart::volumetric) return (1 - 2 * poisson) / 3;
  if (part == EnergyPart::deviatoric) return 2 * (1 + poisson) / 3;
  return 1;
}

LimitEquivalents equivalents(EnergyPart part, double density, double young, double poisson) {
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  const double shear = std::sqrt(2 * density / (young / (2 * (1 + poisson))));
  const double dilation = std::sqrt(2 * density * 3 * (1 - 2 * poisson) / young);
  LimitEquivalents at{stretch_from_density(young, density / uniaxial_share(part, poisson)), shear, dilation};
  if (part == EnergyPart::volumetric) at.shear = unlimited;
  if (part == EnergyPart::deviatoric) at.volume_change = unlimited;
  if (part == EnergyPart::fibre) {
    at.shear = unlimited;               // depends on its plane: none across the fibre
    at.volume_change = 3 * at.stretch;  // a third of it lies along the fibre
  }
  return at;
}

Matrix24d part_stiffness(const HexShape& shape, EnergyPart part, const Vector3d& fibre) {
  if (part == EnergyPart::whole) return shape.stiffness;
  return integrate_stiffness(shape, part_elasticity(part, shape.poisson, fibre));
}

Matrix24d part_stiffness_at(const HexShape& shape, EnergyPart part, const Vector3d& fibre, int point) {
  return shape.volume * point_stiffness(shape, part_elasticity(part, shape.poisson, fibre), point);
}

}  // namespace umax
