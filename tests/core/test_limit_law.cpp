// The terms that limits add: derivatives of the soft barrier, the hard limit's switch.
#include <cmath>

#include "core/element/limit_law.h"
#include "tests/support/catch.h"

using namespace umax;

TEST_CASE("the soft limit's force and curvature are derivatives of its energy, of second order") {
  const SoftLimitOptions options{.kappa = 0.02, .delta = 0.05};
  const double limit = 3;
  const double ratio = GENERATE(0.1, 0.6, 0.9, 0.949, 0.96, 1.0, 1.3);
  CAPTURE(ratio);
  const double U = ratio * limit;
  const LimitTerms terms = soft_limit_terms(U, limit, options);
  double errors[2];
  for (int level = 0; level < 2; ++level) {
    const double d = 1e-3 * limit / (1 << level) * (ratio > 0.94 && ratio < 0.96 ? 0.1 : 1);
    const double slope =
        (soft_limit_energy(U + d, limit, options) - soft_limit_energy(U - d, limit, options)) / (2 * d);
    const double bend =
        (soft_limit_terms(U + d, limit, options).force - soft_limit_terms(U - d, limit, options).force) / (2 * d);
    CHECK(slope == Approx(terms.force).epsilon(1e-3));
    CHECK(bend == Approx(terms.rank_one).epsilon(2e-3));
    errors[level] = std::abs(slope - terms.force);
  }
  if (errors[0] > 1e-9) CHECK(errors[1] < 0.3 * errors[0]);  // 1/4 but for rounding
  CHECK(terms.stiffening == terms.force);
}

TEST_CASE("the hard limit's augmented force is the derivative of its energy") {
  const double limit = 3, penalty = 50;
  for (const double multiplier : {0.0, 4.0})
    for (const double U : {2.0, 2.9, 3.4}) {
      const double d = 1e-6;
      const double slope = (hard_limit_energy(U + d, limit, multiplier, penalty) -
                            hard_limit_energy(U - d, limit, multiplier, penalty)) /
                           (2 * d);
      CHECK(hard_limit_terms(U, limit, multiplier, penalty).force == Approx(slope).margin(1e-7));
    }
}

TEST_CASE("the soft limit joins its quadratic part without a jump in value, slope or curvature") {
  const SoftLimitOptions options;
  const double limit = 2, joint = limit * (1 - options.delta), d = 1e-9;
  CHECK(soft_limit_energy(joint + d, limit, options) ==
        Approx(soft_limit_energy(joint - d, limit, options)).epsilon(1e-6));
  const LimitTerms below = soft_limit_terms(joint - d, limit, options),
                   above = soft_limit_terms(joint + d, limit, options);
  CHECK(below.force == Approx(above.force).epsilon(1e-4));
  CHECK(below.rank_one == Approx(above.rank_one).epsilon(1e-4));
}

TEST_CASE("a hard limit is idle below its limit and pushes with its multiplier on it") {
  CHECK(hard_limit_terms(0.5, 1, 0, 1e4).force == 0);
  CHECK(hard_limit_terms(0.5, 1, 0, 1e4).rank_one == 0);
  const LimitTerms on = hard_limit_terms(2, 2, 3, 1e4);
  CHECK(on.force == Approx(1.5));
  CHECK(on.stiffening == Approx(1.5));
  CHECK(on.rank_one == Approx(1e4 / 4));
  CHECK(hard_limit_terms(2.1, 2, 0, 1e4).force > 0);
}
