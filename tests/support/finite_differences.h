// Derivatives against central differences, judged by the order in which the error falls: a wrong derivative has order
// 0.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/finite_differences.h"
#include "core/base/types.h"

namespace umax::test {

struct Convergence {
  double lowest_order = 1e300, highest_order = -1e300;  // of the three halvings
  double last_error = 0;                                // relative, at the smallest step
};

/// error(h) -> relative error of the difference quotient with step h; called for h, h/2, h/4, h/8.
template <class Error>
Convergence convergence(double h, const Error& error) {
  std::array<double, 4> e;
  for (int k = 0; k < 4; ++k) e[k] = error(h / (1 << k));
  Convergence result{.last_error = e[3]};
  for (int k = 0; k < 3; ++k) {
    const double order = std::log2(e[k] / e[k + 1]);
    result.lowest_order = std::min(result.lowest_order, order);
    result.highest_order = std::max(result.highest_order, order);
  }
  return result;
}

/// Central differences of a vector function; column i is the derivative by x_i.
template <class Function>
Matrix24d difference_jacobian(const Function& f, const Vector24d& x, double h) {
  Matrix24d jacobian;
  for (int i = 0; i < 24; ++i) {
    Vector24d plus = x, minus = x;
    plus[i] += h;
    minus[i] -= h;
    jacobian.col(i) = (f(plus) - f(minus)) / (2 * h);
  }
  return jacobian;
}

}  // namespace umax::test
