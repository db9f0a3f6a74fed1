// How a limit on an energy enters the minimisation: what it adds to an element's gradient and Hessian.
//
// Gradient  + force G
// Hessian   + stiffening H + rank_one G G^T
//
// Hard: augmented Lagrangian, active iff t > 0
//   t          = lambda + rho (U/U_max - 1)
//   energy     = t^2 / (2 rho)
//   force      = t / U_max
//   stiffening = lambda / U_max          not t: the rank-one term already holds rho
//   rank_one   = rho / U_max^2
//
// Soft: relaxed logarithmic barrier
//   energy     = kappa U_max phi(s),     s = 1 - U/U_max
//   phi        = -log s                                            for s >= delta
//   phi        = 1/2 (((s - 2 delta)/delta)^2 - 1) - log delta     below: the same value, slope and curvature at delta
//   force      = stiffening = -kappa phi'
//   rank_one   = kappa phi'' / U_max
//
// U: energy that the limit measures [J], G = dU/dx [N], H = d2U/dx2 [N/m];  U_max: its limit [J]
// lambda: multiplier [J];  rho: penalty [J];  kappa, delta: SoftLimitOptions [-]
#pragma once

#include <algorithm>
#include <cmath>

namespace umax {

struct LimitTerms {
  double force = 0;       // [-]
  double stiffening = 0;  // [-]
  double rank_one = 0;    // [1/J]
};

struct SoftLimitOptions {
  double kappa = 0.01;  // [-] barrier weight relative to U_max; raising it begins to stiffen earlier
  double delta = 1e-3;  // [-] distance to the limit below which the barrier is quadratic
};

/// Of a limit that is held, beyond it or not. multiplier: force-level lambda [J]; penalty: rho [J].
inline LimitTerms held_limit_terms(double energy, double limit, double multiplier, double penalty) {
  return {(multiplier + penalty * (energy / limit - 1)) / limit, multiplier / limit, penalty / (limit * limit)};
}

/// The same where it is active, nothing elsewhere.
inline LimitTerms hard_limit_terms(double energy, double limit, double multiplier, double penalty) {
  const LimitTerms held = held_limit_terms(energy, limit, multiplier, penalty);
  return held.force > 0 ? held : LimitTerms{};
}

/// Value [J] of the augmented term whose slope is hard_limit_terms().force.
inline double hard_limit_energy(double energy, double limit, double multiplier, double penalty) {
  const double t = std::max(0.0, multiplier + penalty * (energy / limit - 1));
  return t * t / (2 * penalty);
}

/// Value [J] of the barrier, and its terms.
inline double soft_limit_energy(double energy, double limit, const SoftLimitOptions& options) {
  const double s = 1 - energy / limit, delta = options.delta;
  const double r = (s - 2 * delta) / delta;
  const double phi = s >= delta ? -std::log(s) : 0.5 * (r * r - 1) - std::log(delta);
  return options.kappa * limit * phi;
}
inline LimitTerms soft_limit_terms(double energy, double limit, const SoftLimitOptions& options) {
  const double s = 1 - energy / limit, delta = options.delta;
  const double slope = s >= delta ? -1 / s : (s - 2 * delta) / (delta * delta);  // phi'
  const double curvature = s >= delta ? 1 / (s * s) : 1 / (delta * delta);       // phi''
  return {-options.kappa * slope, -options.kappa * slope, options.kappa * curvature / limit};
}

}  // namespace umax
