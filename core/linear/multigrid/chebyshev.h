// Chebyshev's iteration, as smoother and as solver: the coefficients of its steps for eigenvalues in a given interval.
//
//   Saad, Iterative Methods for Sparse Linear Systems (2nd edition, 2003), Algorithm 12.1:
//   d_0 = r_0 / theta,  d_n = rho_n rho_{n-1} d_{n-1} + 2 rho_n / delta r_n,  x_{n+1} = x_n + d_n
//   rho_0 = delta / theta,  rho_n = 1 / (2 theta / delta - rho_{n-1})
// theta: the interval's centre; delta: half its length; r_n: the residual, preconditioned
#pragma once

namespace umax {

/// Steps through the recurrence in the arithmetic of T. The first step is d_0 = first_gain r_0.
template <class T>
class ChebyshevRecurrence {
 public:
  /// For eigenvalues from largest / interval to largest.
  ChebyshevRecurrence(T largest, T interval)
      : theta_(largest * (1 + 1 / interval) / 2), delta_(largest * (1 - 1 / interval) / 2), rho_(delta_ / theta_) {}

  T first_gain() const { return 1 / theta_; }

  /// Of the next step d = momentum (d before) + gain r.
  struct Step {
    T momentum = 0, gain = 0;
  };
  Step next() {
    const T rho = 1 / (2 * theta_ / delta_ - rho_);
    const Step step{rho * rho_, 2 * rho / delta_};
    rho_ = rho;
    return step;
  }

 private:
  T theta_, delta_, rho_;
};

}  // namespace umax
