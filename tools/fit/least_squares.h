// Nonlinear least squares with bounds, and what the residuals tell of the parameters' errors. Ceres lives here.
#pragma once

#include <functional>
#include <vector>

#include "core/base/types.h"

namespace umax {

struct LeastSquaresProblem {
  int num_residuals = 0;
  /// Fills the residuals at the parameters; false where there are none to be had: no solution is there.
  std::function<bool(const double* parameters, double* residuals)> residuals;
  std::vector<double> start;
  std::vector<double> low, high;  // bounds of each parameter
};

struct LeastSquaresSolution {
  bool converged = false;
  std::vector<double> parameters;
  double sum_of_squares = 0;
  // of the parameters; empty where the residuals do not tell them apart
  MatrixXd covariance;         // for residuals of unit variance
  MatrixXd robust_covariance;  // for residuals whose variances differ as they seem to (HC3)
};

/// Levenberg-Marquardt with central differences, on one thread: the same result everywhere.
LeastSquaresSolution solve_least_squares(const LeastSquaresProblem& problem);

}  // namespace umax
