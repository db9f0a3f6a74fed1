#include "core/element/energy_parts.h"

#include <Eigen/Geometry>

#include "core/element/elastic_energy.h"
#include "core/element/material.h"
#include "tests/support/catch.h"
#include "tests/support/finite_differences.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double young = 150e3, poisson = 0.3;
const Vector3d fibre = Vector3d(2, -1, 0.5).normalized();

struct Form {
  EnergyPart part;
  Matrix24d K;
};

// the four parts, integrated and at two of the points
std::vector<Form> forms_of(const HexShape& shape) {
  std::vector<Form> forms;
  for (const EnergyPart part : {EnergyPart::whole, EnergyPart::volumetric, EnergyPart::deviatoric, EnergyPart::fibre}) {
    forms.push_back({part, part_stiffness(shape, part, fibre)});
    for (const int point : {0, 5}) forms.push_back({part, part_stiffness_at(shape, part, fibre, point)});
  }
  return forms;
}

// written from the definitions, with the bulk modulus and none of core's elasticity matrices
double density(EnergyPart part, const Matrix3d& eps) {
  const double bulk = young / (3 * (1 - 2 * poisson)), mu = young / (2 * (1 + poisson));
  const Matrix3d dev = eps - eps.trace() / 3 * Matrix3d::Identity();
  const double volumetric = 0.5 * bulk * eps.trace() * eps.trace(), deviatoric = mu * dev.squaredNorm();
  const double along = fibre.dot(eps * fibre);
  switch (part) {
    case EnergyPart::whole:
      return volumetric + deviatoric;
    case EnergyPart::volumetric:
      return volumetric;
    case EnergyPart::deviatoric:
      return deviatoric;
    case EnergyPart::fibre:
      break;
  }
  return 0.5 * young * along * along;
}

Matrix3d strain_at(const HexShape& shape, const CorotatedHex& hex, int point) {
  const Matrix3d gradient = as_nodes(hex.displacement).transpose() * shape.gradients[point];
  return 0.5 * (gradient + gradient.transpose());
}

// density of a part under a homogeneous strain
double homogeneous(EnergyPart part, const Matrix3d& strain) {
  const HexShape shape = make_hex_shape(distorted_nodes(), poisson);
  const Matrix8x3d x = affine(shape.rest_nodes, Random(3).rotation() * (Matrix3d::Identity() + strain));
  const CorotatedHex hex = corotate(shape, RotationEstimate::centre, x);
  const double mean = elastic_energy(part_stiffness(shape, part, fibre), young, hex) / shape.volume;
  for (int q = 0; q < 8; ++q)
    CHECK(elastic_energy(part_stiffness_at(shape, part, fibre, q), young, hex) / shape.volume ==
          Approx(mean).epsilon(1e-10).margin(1e-9));
  return mean;
}

Matrix3d uniaxial(const Vector3d& d, double s) {
  return s * (1 + poisson) * d * d.transpose() - s * poisson * Matrix3d::Identity();
}

}  // namespace

TEST_CASE("the energy of a part is its density summed over the quadrature points, its peak form one point of it") {
  Random random(1);
  for (const Matrix8x3d& nodes : {box_nodes({1, 0.8, 1.1}), distorted_nodes()}) {
    const HexShape shape = make_hex_shape(nodes, poisson);
    const CorotatedHex hex = corotate(shape, RotationEstimate::centre, deformed(shape.rest_nodes, random, 0.2));
    for (const EnergyPart part :
         {EnergyPart::whole, EnergyPart::volumetric, EnergyPart::deviatoric, EnergyPart::fibre}) {
      double sum = 0;
      for (int q = 0; q < 8; ++q) {
        const double at_point = density(part, strain_at(shape, hex, q));
        sum += shape.weights[q] * at_point;
        CHECK(elastic_energy(part_stiffness_at(shape, part, fibre, q), young, hex) ==
              Approx(shape.volume * at_point).epsilon(1e-12));
      }
      CHECK(elastic_energy(part_stiffness(shape, part, fibre), young, hex) == Approx(sum).epsilon(1e-12));
    }
  }
}

TEST_CASE("the volumetric and the deviatoric part sum to the whole energy") {
  Random random(2);
  const HexShape shape = make_hex_shape(distorted_nodes(), poisson);
  const Matrix24d sum =
      part_stiffness(shape, EnergyPart::volumetric, fibre) + part_stiffness(shape, EnergyPart::deviatoric, fibre);
  CHECK((sum - shape.stiffness).norm() < 1e-14 * shape.stiffness.norm());
  Matrix24d points = Matrix24d::Zero();
  for (int q = 0; q < 8; ++q)
    points += shape.weights[q] / shape.volume * part_stiffness_at(shape, EnergyPart::whole, fibre, q);
  CHECK((points - shape.stiffness).norm() < 1e-14 * shape.stiffness.norm());
}

TEST_CASE("rigid motion costs no part any energy or force") {
  Random random(3);
  for (const Matrix8x3d& nodes : {box_nodes({1, 0.8, 1.1}), distorted_nodes()}) {
    const HexShape shape = make_hex_shape(nodes, poisson);
    for (const Form& form : forms_of(shape)) {
      const CorotatedHex hex =
          corotate(shape, RotationEstimate::centre, affine(shape.rest_nodes, random.rotation(), random.vector(10)));
      CHECK(elastic_energy(form.K, young, hex) < 1e-12);
      CHECK(exact_gradient(form.K, young, shape.rotation_gradients[0], hex).cwiseAbs().maxCoeff() < 1e-12 * young);
    }
  }
}

TEST_CASE("gradient and hessian of every part match finite differences to second order") {
  Random random(4);
  for (const RotationEstimate estimate : rotation_estimates)
    for (const Matrix8x3d& nodes : {box_nodes({1, 0.8, 1.1}), distorted_nodes()}) {
      const HexShape shape = make_hex_shape(nodes, poisson);
      const Matrix8x3d& h = shape.rotation_gradients[int(estimate)];
      for (const Form& form : forms_of(shape)) {
        CAPTURE(int(estimate), int(form.part));
        const Vector24d x = stacked(deformed(shape.rest_nodes, random, 0.15));
        const auto at = [&](const Vector24d& y) { return corotate(shape, estimate, as_nodes(y)); };
        const auto energy = [&](const Vector24d& y) { return elastic_energy(form.K, 1, at(y)); };
        const auto gradient = [&](const Vector24d& y) { return exact_gradient(form.K, 1, h, at(y)); };
        const Vector24d exact = gradient(x);
        const auto slope =
            convergence(0.01, [&](double step) { return relative_error(difference_gradient(energy, x, step), exact); });
        CHECK(slope.lowest_order > 1.95);
        CHECK(slope.highest_order < 2.05);
        CHECK(slope.last_error < 1e-3);
        const Matrix24d hessian = exact_hessian(form.K, 1, h, at(x));
        const auto curvature = convergence(
            0.01, [&](double step) { return relative_error(difference_jacobian(gradient, x, step), hessian); });
        CHECK(curvature.lowest_order > 1.95);
        CHECK(curvature.highest_order < 2.05);
        CHECK(curvature.last_error < 1e-3);
      }
    }
}

TEST_CASE("closed forms: uniaxial stretch, pure shear and pure dilation in each part") {
  for (const double s : {-0.2, 0.07}) {
    const double unit = density_from_stretch(young, s);
    const Matrix3d along = uniaxial(fibre, s);
    CHECK(homogeneous(EnergyPart::whole, along) == Approx(unit));
    CHECK(homogeneous(EnergyPart::volumetric, along) == Approx(unit * (1 - 2 * poisson) / 3));
    CHECK(homogeneous(EnergyPart::deviatoric, along) == Approx(unit * 2 * (1 + poisson) / 3));
    CHECK(homogeneous(EnergyPart::fibre, along) == Approx(unit));
    // what uniaxial_share() says
    for (const EnergyPart part : {EnergyPart::whole, EnergyPart::volumetric, EnergyPart::deviatoric, EnergyPart::fibre})
      CHECK(homogeneous(part, along) == Approx(unit * uniaxial_share(part, poisson)));

    // symmetric pure shear across the fibre: no volume, no fibre stretch
    const Vector3d a = fibre.unitOrthogonal(), b = fibre.cross(a);
    const Matrix3d shear = 0.5 * s * (a * b.transpose() + b * a.transpose());
    const double mu = young / (2 * (1 + poisson));
    CHECK(homogeneous(EnergyPart::deviatoric, shear) == Approx(0.5 * mu * s * s));
    CHECK(homogeneous(EnergyPart::volumetric, shear) < 1e-12 * unit);
    CHECK(homogeneous(EnergyPart::fibre, shear) < 1e-12 * unit);

    // dilation
    const double bulk = young / (3 * (1 - 2 * poisson));
    CHECK(homogeneous(EnergyPart::volumetric, s / 3 * Matrix3d::Identity()) == Approx(0.5 * bulk * s * s));
    CHECK(homogeneous(EnergyPart::deviatoric, s / 3 * Matrix3d::Identity()) < 1e-12 * unit);
    CHECK(homogeneous(EnergyPart::fibre, s / 3 * Matrix3d::Identity()) == Approx(unit / 9));
  }
}

TEST_CASE("equivalents: the strain of each kind that fills a limit fills it") {
  const double limit = 700;  // [J/m^3]
  for (const EnergyPart part : {EnergyPart::whole, EnergyPart::volumetric, EnergyPart::deviatoric, EnergyPart::fibre}) {
    const LimitEquivalents at = equivalents(part, limit, young, poisson);
    CHECK(homogeneous(part, uniaxial(fibre, at.stretch)) == Approx(limit));
    const Vector3d a = fibre.unitOrthogonal(), b = fibre.cross(a);
    if (std::isfinite(at.shear))
      CHECK(homogeneous(part, 0.5 * at.shear * (a * b.transpose() + b * a.transpose())) == Approx(limit));
    if (std::isfinite(at.volume_change))
      CHECK(homogeneous(part, at.volume_change / 3 * Matrix3d::Identity()) == Approx(limit));
  }
  CHECK(std::isinf(equivalents(EnergyPart::volumetric, limit, young, poisson).shear));
  CHECK(std::isinf(equivalents(EnergyPart::deviatoric, limit, young, poisson).volume_change));
  const LimitEquivalents fibre_limit = equivalents(EnergyPart::fibre, limit, young, poisson);
  CHECK(std::isinf(fibre_limit.shear));
  CHECK(fibre_limit.volume_change == Approx(3 * fibre_limit.stretch));
}
