#include "tools/fit/least_squares.h"

#include <ceres/ceres.h>
#include <ceres/dynamic_numeric_diff_cost_function.h>

#include <Eigen/LU>
#include <algorithm>

namespace umax {
namespace {

constexpr double far = 1e6;  // larger than any residual

struct Residuals {
  const LeastSquaresProblem* problem;
  bool operator()(double const* const* parameters, double* residuals) const {
    // Ceres would complain on the terminal of residuals that are not there: a step to worse ones is taken back as well
    if (!problem->residuals(parameters[0], residuals)) std::fill_n(residuals, problem->num_residuals, far);
    return true;
  }
};

/// Covariances of the parameters:
///   C   = (J^T J)^-1
///   HC3 = C J^T diag(r_i / (1 - h_i))^2 J C          MacKinnon and White 1985; h_i: leverages
/// Left empty where C does not exist. (ceres::Covariance would complain on the terminal.)
void add_covariances(ceres::Problem& problem, LeastSquaresSolution& solution) {
  ceres::CRSMatrix jacobian;
  std::vector<double> residuals;
  if (!problem.Evaluate({}, nullptr, &residuals, nullptr, &jacobian)) return;
  MatrixXd J = MatrixXd::Zero(jacobian.num_rows, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row)
    for (int k = jacobian.rows[std::size_t(row)]; k < jacobian.rows[std::size_t(row) + 1]; ++k)
      J(row, jacobian.cols[std::size_t(k)]) = jacobian.values[std::size_t(k)];
  const VectorXd norms = J.colwise().norm().transpose();
  if (!(norms.minCoeff() > 0)) return;
  const VectorXd scale = norms.cwiseInverse();
  const MatrixXd scaled = J * scale.asDiagonal();
  Eigen::FullPivLU<MatrixXd> normal(scaled.transpose() * scaled);
  normal.setThreshold(1e-10);
  if (!normal.isInvertible()) return;
  const MatrixXd C = scale.asDiagonal() * normal.inverse() * scale.asDiagonal();
  MatrixXd spread = MatrixXd::Zero(C.rows(), C.cols());
  for (Eigen::Index row = 0; row < J.rows(); ++row) {
    const double leverage = std::min(0.999, (J.row(row) * C).dot(J.row(row)));
    const double residual = residuals[std::size_t(row)] / (1 - leverage);
    spread += residual * residual * J.row(row).transpose() * J.row(row);
  }
  solution.covariance = C;
  solution.robust_covariance = C * spread * C;
}

}  // namespace

LeastSquaresSolution solve_least_squares(const LeastSquaresProblem& least_squares) {
  LeastSquaresSolution solution;
  solution.parameters = least_squares.start;
  double* const parameters = solution.parameters.data();
  const int size = int(solution.parameters.size());

  std::vector<double> residuals(std::size_t(least_squares.num_residuals));
  if (!least_squares.residuals(parameters, residuals.data())) return solution;

  ceres::NumericDiffOptions differences;
  differences.relative_step_size = 1e-5;
  // the problem owns the function, which owns the functor
  auto* const function = new ceres::DynamicNumericDiffCostFunction<Residuals, ceres::CENTRAL>(
      new Residuals{&least_squares}, ceres::TAKE_OWNERSHIP, differences);
  function->AddParameterBlock(size);
  function->SetNumResiduals(least_squares.num_residuals);
  ceres::Problem problem;
  problem.AddResidualBlock(function, nullptr, parameters);
  for (int i = 0; i < size; ++i) {
    problem.SetParameterLowerBound(parameters, i, least_squares.low[std::size_t(i)]);
    problem.SetParameterUpperBound(parameters, i, least_squares.high[std::size_t(i)]);
  }

  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-10;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  solution.converged = summary.IsSolutionUsable() && least_squares.residuals(parameters, residuals.data());
  solution.sum_of_squares = 2 * summary.final_cost;
  if (solution.converged) add_covariances(problem, solution);
  return solution;
}

}  // namespace umax
