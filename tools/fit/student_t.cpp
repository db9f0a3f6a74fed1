#include "tools/fit/student_t.h"

#include <cmath>
#include <numbers>

namespace umax {
namespace {

// Abramowitz and Stegun 26.7.3, 26.7.4: P(|T| <= t) as a finite sum, theta = atan(t / sqrt(degrees))
double within(double t, int degrees) {
  const double theta = std::atan(t / std::sqrt(double(degrees)));
  const double sine = std::sin(theta), cosine = std::cos(theta);
  const bool odd = degrees % 2 == 1;
  double term = odd ? cosine : 1, sum = 0;
  for (int k = odd ? 3 : 2; k <= degrees; k += 2) {
    sum += term;
    term *= cosine * cosine * (k - 1) / k;
  }
  return odd ? 2 / std::numbers::pi * (theta + sine * sum) : sine * sum;
}

}  // namespace

double student_t_probability(double t, int degrees_of_freedom) {
  return 0.5 + 0.5 * (t < 0 ? -within(-t, degrees_of_freedom) : within(t, degrees_of_freedom));
}

double student_t_quantile(double probability, int degrees_of_freedom) {
  double low = -1e6, high = 1e6;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (student_t_probability(middle, degrees_of_freedom) < probability ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace umax
