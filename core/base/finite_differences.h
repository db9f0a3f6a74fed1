// Derivatives of an element's functions by central differences: what the derived formulas are compared with, in tests
// and in `umax reproduce corrections`.
#pragma once

#include "core/base/types.h"

namespace umax {

/// Of a scalar function of 24 coordinates (Vector24d or Matrix8x3d). Exact but for rounding where f is quadratic.
template <class Function, class Coordinates>
Vector24d difference_gradient(const Function& f, const Coordinates& x, double h) {
  Vector24d gradient;
  for (int i = 0; i < 24; ++i) {
    Coordinates plus = x, minus = x;
    plus.data()[i] += h;
    minus.data()[i] -= h;
    gradient[i] = (f(plus) - f(minus)) / (2 * h);
  }
  return gradient;
}

/// |found - expected| / |expected|
template <class A, class B>
double relative_error(const A& found, const B& expected) {
  return (found - expected).norm() / expected.norm();
}

}  // namespace umax
