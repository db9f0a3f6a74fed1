#include "core/element/energy_limit.h"

namespace umax {

const Matrix24d& measured_stiffness(const HexShape& shape, EnergyMeasure measure) {
  return measure == EnergyMeasure::true_energy ? shape.stiffness : shape.stiffness_paper;
}

double energy_limit_value(const HexShape& shape, EnergyMeasure measure, double young, double limit,
                          const CorotatedHex& hex) {
  return 1 - elastic_energy(measured_stiffness(shape, measure), young, hex) / limit;
}

Vector24d energy_limit_jacobian(const HexShape& shape, EnergyMeasure measure, LimitJacobian jacobian,
                                RotationEstimate estimate, double young, double limit, const CorotatedHex& hex) {
  switch (jacobian) {
    case LimitJacobian::exact:
      return exact_gradient(measured_stiffness(shape, measure), young, shape.rotation_gradients[int(estimate)], hex) /
             -limit;
    case LimitJacobian::fixed_rotation:
      return warped_gradient(measured_stiffness(shape, measure), young, hex) / -limit;
    case LimitJacobian::warped:
      break;
  }
  return warped_gradient(shape.stiffness, young, hex) / -limit;
}

}  // namespace umax
