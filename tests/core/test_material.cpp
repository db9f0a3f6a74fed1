#include "core/element/material.h"

#include <Eigen/LU>

#include "tests/support/catch.h"
#include "tests/support/eigenvalues.h"

using namespace umax;
using Vector6d = Eigen::Matrix<double, 6, 1>;

TEST_CASE("a uniaxial stress stretches by stress over Young's modulus and thins by Poisson's ratio") {
  const double young = 150e3, poisson = GENERATE(-0.5, 0.0, 0.3, 0.49);
  const auto E = elasticity_matrix(young, poisson);
  Vector6d stress = Vector6d::Zero();
  stress[0] = 300;
  const Vector6d strain = E.inverse() * stress;
  CHECK(strain[0] == Approx(300 / young).epsilon(1e-12));
  CHECK(strain[1] == Approx(-poisson * 300 / young).epsilon(1e-10).margin(1e-15));
  CHECK(strain[2] == Approx(-poisson * 300 / young).epsilon(1e-10).margin(1e-15));
  CHECK(strain.tail<3>().norm() == 0);
}

TEST_CASE("the moduli are those of an isotropic material") {
  const auto m = moduli(1e6, 0.3);
  CHECK(m.E1 == Approx(m.E2 + 2 * m.E3).epsilon(1e-14));  // lambda + 2 mu
  CHECK(m.E3 == Approx(1e6 / 2.6).epsilon(1e-14));
  CHECK(m.E2 == Approx(1e6 * 0.3 / (1.3 * 0.4)).epsilon(1e-14));

  // engineering shear of 2 eps gives the stress 2 mu eps; the matrix is positive definite for every admissible ratio
  CHECK(elasticity_matrix(1e6, 0.3)(3, 3) == Approx(m.E3).epsilon(1e-15));
  for (const double poisson : {-0.99, 0.0, 0.499}) CHECK(test::eigenvalues(elasticity_matrix(1, poisson))[0] > 0);
}

TEST_CASE("limits as stretch and as density are one another's inverse") {
  CHECK(density_from_stretch(150e3, 0.228) == Approx(0.5 * 150e3 * 0.228 * 0.228));
  for (const double strain : {0.01, 0.2, 1.5})
    CHECK(stretch_from_density(500e3, density_from_stretch(500e3, strain)) == Approx(strain).epsilon(1e-14));
}
