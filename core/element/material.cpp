#include "core/element/material.h"

#include <cmath>

namespace umax {

Moduli moduli(double young, double poisson) {
  const double common = young / ((1 + poisson) * (1 - 2 * poisson));
  return {.E1 = common * (1 - poisson), .E2 = common * poisson, .E3 = young / (2 * (1 + poisson))};
}

Matrix6d elasticity_matrix(double young, double poisson) {
  const Moduli m = moduli(young, poisson);
  Matrix6d E = Matrix6d::Zero();
  E.topLeftCorner<3, 3>().setConstant(m.E2);
  E.diagonal() << m.E1, m.E1, m.E1, m.E3, m.E3, m.E3;
  return E;
}

double density_from_stretch(double young, double strain) {
  return 0.5 * young * strain * strain;
}

double stretch_from_density(double young, double density) {
  return std::sqrt(2 * density / young);
}

}  // namespace umax
