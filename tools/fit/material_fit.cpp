#include "tools/fit/material_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "tools/fit/curve_shape.h"
#include "tools/fit/least_squares.h"
#include "tools/fit/student_t.h"

namespace umax {
namespace {

constexpr int fewest_at_limit = 3, fewest_below_limit = 3;
constexpr double clear_improvement = 15;  // [-] F of the limit's parameter: about one in a thousand by chance
constexpr double steepest_limit = 0.5;    // [-] of the elastic compliance: where more of it is left, there is no limit
constexpr double noticeable_give = 0.1;   // [-] likewise: from here on it is said
constexpr double notable_correlation =
    2.3;                               // of neighbouring residuals, in its standard errors: one in a hundred by chance
constexpr int fewest_for_robust = 20;  // degrees of freedom from which residuals tell their own variances
constexpr double least_poisson = -0.99, largest_poisson = 0.4999;

/// Which parameters a fit adjusts, in this order: log Young's modulus, log limit, Poisson's ratio.
struct Fit {
  bool with_limit = false, with_poisson = false;
  FitMaterial material;
  double sum_of_squares = 0;  // [-] of residuals over their scale
  MatrixXd covariance, robust_covariance;

  int num_parameters() const { return 1 + with_limit + with_poisson; }
};

FitMaterial material_of(const Fit& fit, const double* parameters) {
  FitMaterial material = fit.material;
  material.young = std::exp(parameters[0]);
  if (fit.with_limit) material.limit_stretch = std::exp(parameters[1]);
  if (fit.with_poisson) material.poisson = parameters[1 + fit.with_limit];
  return material;
}

/// Measurements and the specimen that repeats them.
class Fitter {
 public:
  Fitter(const Measurements& measurements, double poisson, FitModel& model) : data_(measurements), model_(model) {
    start_.poisson = poisson;
    lateral_ = measurements.has_lateral;
    for (const MeasuredPoint& point : data_.points) {
      scale_ = std::max(scale_, std::abs(point.stretch));
      if (std::isfinite(point.lateral_stretch)) ++num_lateral_;
    }
    lateral_scale_ = scale_;
  }

  int num_residuals() const { return int(data_.points.size()) + num_lateral_; }
  FitModel& model() { return model_; }
  bool lateral() const { return lateral_; }
  double largest_stretch() const { return scale_; }

  /// Adjusts the parameters that the fit names, from its material on. False where that fails.
  bool solve(Fit& fit) {
    LeastSquaresProblem problem;
    problem.num_residuals = num_residuals();
    problem.residuals = [&](const double* parameters, double* residuals) {
      return fill_residuals(material_of(fit, parameters), residuals);
    };
    problem.start = {std::log(fit.material.young)};
    problem.low = {problem.start[0] - 7};
    problem.high = {problem.start[0] + 7};
    if (fit.with_limit) {
      problem.start.push_back(std::log(fit.material.limit_stretch));
      problem.low.push_back(problem.start[1] - 3);
      problem.high.push_back(problem.start[1] + 3);
    }
    if (fit.with_poisson) {
      problem.start.push_back(std::clamp(fit.material.poisson, least_poisson, largest_poisson));
      problem.low.push_back(least_poisson);
      problem.high.push_back(largest_poisson);
    }
    const LeastSquaresSolution solution = solve_least_squares(problem);
    if (!solution.converged) return false;
    fit.material = material_of(fit, solution.parameters.data());
    fit.sum_of_squares = solution.sum_of_squares;
    fit.covariance = solution.covariance;
    fit.robust_covariance = solution.robust_covariance;
    return true;
  }

  /// From here on both kinds of stretch count by how well they are fitted.
  void weigh_by(const Fit& fit) {
    std::vector<double> residuals(data_.points.size() + std::size_t(num_lateral_));
    fill_residuals(fit.material, residuals.data());
    const auto middle = residuals.begin() + std::ptrdiff_t(data_.points.size());
    const auto rms = [](auto begin, auto end) {
      return std::sqrt(std::inner_product(begin, end, begin, 0.0) / double(end - begin));
    };
    const double ratio = rms(middle, residuals.end()) / rms(residuals.begin(), middle);
    if (ratio > 1e-6 && ratio < 1e6) lateral_scale_ *= ratio;
  }

  Fit start() const {
    return {.with_limit = false,
            .with_poisson = lateral_,
            .material = start_,
            .sum_of_squares = 0,
            .covariance = {},
            .robust_covariance = {}};
  }

 private:
  bool fill_residuals(const FitMaterial& material, double* residuals) {
    double* lateral = residuals + data_.points.size();
    for (const MeasuredPoint& point : data_.points) {
      const auto reading = model_.at(material, point.stress);
      if (!reading) return false;
      *residuals++ = (reading->stretch - point.stretch) / scale_;
      if (std::isfinite(point.lateral_stretch))
        *lateral++ = (reading->lateral_stretch - point.lateral_stretch) / lateral_scale_;
    }
    return true;
  }

  const Measurements& data_;
  FitModel& model_;
  FitMaterial start_;
  bool lateral_ = false;
  int num_lateral_ = 0;
  double scale_ = 0, lateral_scale_ = 0;  // [-] of stretches
};

/// Young's modulus over the stiffness that is measured.
double shear_factor(TestKind test, double poisson) {
  return test == TestKind::shear ? 2 * (1 + poisson) : 1;
}

std::vector<char> limited_points(const Measurements& data, FitModel& model, const FitMaterial& material) {
  std::vector<char> limited;
  for (const MeasuredPoint& point : data.points) limited.push_back(model.is_limited(material, point.stress));
  return limited;
}

int count(const std::vector<char>& flags) {
  return int(std::count(flags.begin(), flags.end(), 1));
}

[[noreturn]] void refuse(const Measurements& data, const std::string& what, const std::string& value,
                         const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = data.name, .what = what, .value = value, .remedy = remedy});
}

/// Estimates with intervals of Student's t, from the curvature at the solution. Parameters are logarithms or not.
Estimate interval(const Fit& fit, int parameter, double value, bool logarithmic, int degrees) {
  if (fit.covariance.size() == 0 || degrees < 1) return {value, logarithmic ? 0 : -no_limit, no_limit};
  // noise may grow with the stretch; too few points do not tell
  const double variance = degrees >= fewest_for_robust
                              ? fit.robust_covariance(parameter, parameter)
                              : fit.covariance(parameter, parameter) * fit.sum_of_squares / degrees;
  const double reach = student_t_quantile(0.975, degrees) * std::sqrt(std::max(0.0, variance));
  if (logarithmic) return {value, value * std::exp(-reach), value * std::exp(reach)};
  return {value, value - reach, value + reach};
}

/// The least limit that the data do not rule out (one-sided, 95 %): with it the squares grow no more than chance makes
/// them.
double limit_bound(Fitter& fitter, const Fit& unlimited, const Measurements& data) {
  const int degrees = fitter.num_residuals() - unlimited.num_parameters();
  const double t = student_t_quantile(0.95, std::max(1, degrees));
  const double allowed = unlimited.sum_of_squares * (1 + t * t / std::max(1, degrees));
  double highest = 0;
  for (const MeasuredPoint& point : data.points)
    if (const auto reading = fitter.model().at(unlimited.material, point.stress))
      highest = std::max(highest, reading->peak_stretch);
  double low = 0.2 * highest, high = highest;
  for (int i = 0; i < 20; ++i) {
    const double middle = (low + high) / 2;
    Fit fit = unlimited;
    fit.with_poisson = false;
    fit.material.limit_stretch = middle;
    const bool possible = fitter.solve(fit) && fit.sum_of_squares <= allowed;
    (possible ? high : low) = middle;
  }
  return high;
}

void describe_misfit(const Measurements& data, FitModel& model, const FitMaterial& material, MaterialFit& result) {
  double squares = 0, largest = 0, worst = -1;
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    const SpecimenReading reading = *model.at(material, data.points[i].stress);
    result.stretch.push_back(reading.stretch);
    if (data.has_lateral) result.lateral_stretch.push_back(reading.lateral_stretch);
    const double residual = std::abs(data.points[i].stretch - reading.stretch);
    squares += residual * residual;
    largest = std::max(largest, std::abs(data.points[i].stretch));
    if (residual > worst) worst = residual, result.worst = i;
  }
  result.rms = std::sqrt(squares / double(data.points.size()));
  if (data.points.size() >= 8 && result.rms > 1e-6 * largest &&
      residual_correlation(data, result.stretch) * std::sqrt(double(data.points.size())) > notable_correlation)
    result.warnings.push_back(
        "neighbouring rows are off to the same side: these data do not follow a linear law with a limit, and the "
        "intervals, which take residuals for noise, say too little");
}

/// Whether the limit of a fit is one that the data show.
bool shows_limit(const Measurements& data, Fitter& fitter, const Fit& unlimited, const Fit& limited) {
  const std::vector<char> at_limit = limited_points(data, fitter.model(), limited.material);
  const int degrees = fitter.num_residuals() - limited.num_parameters();
  if (count(at_limit) < fewest_at_limit || degrees < 1) return false;
  const double gain = unlimited.sum_of_squares - limited.sum_of_squares;
  return gain * degrees > clear_improvement * limited.sum_of_squares &&
         compliance_left(data, at_limit, limited.material.young) < steepest_limit;
}

/// The fit with a limit, from where the data bend; nothing where they do not.
std::optional<Fit> solve_limited(const Measurements& data, Fitter& fitter, double stiffness_factor) {
  const Knee knee = find_knee(data);
  if (knee.stretch <= 0) return std::nullopt;
  Fit fit = fitter.start();
  fit.with_limit = true;
  fit.material.young = stiffness_factor * knee.stiffness;
  fit.material.limit_stretch = knee.stretch / std::sqrt(stiffness_factor);
  if (!fitter.solve(fit)) return std::nullopt;
  return fit;
}

double largest_stress(const Measurements& data) {
  double largest = 0;
  for (const MeasuredPoint& point : data.points) largest = std::max(largest, std::abs(point.stress));
  return largest;
}

MaterialFit result_of(const Measurements& data, Fitter& fitter, const Fit& fit, double poisson) {
  MaterialFit result;
  const int degrees = fitter.num_residuals() - fit.num_parameters();
  result.assumed_poisson = poisson;
  result.young = interval(fit, 0, fit.material.young, true, degrees);
  if (fit.with_limit) result.limit = interval(fit, 1, fit.material.limit_stretch, true, degrees);
  if (fit.with_poisson) {
    result.poisson = interval(fit, 1 + fit.with_limit, fit.material.poisson, false, degrees);
    result.poisson->low = std::max(-1.0, result.poisson->low);
    result.poisson->high = std::min(0.5, result.poisson->high);
  }
  if (fit.covariance.size() == 0)
    result.warnings.push_back("the data do not tell the values apart: no confidence intervals");
  describe_misfit(data, fitter.model(), fit.material, result);
  return result;
}

void check_limited(const Measurements& data, const std::vector<char>& at_limit, const Fit& fit, MaterialFit& result) {
  result.points_at_limit = count(at_limit);
  const int below = int(std::count_if(data.points.begin(), data.points.end(), [&](const MeasuredPoint& point) {
    return point.stress != 0 && !at_limit[std::size_t(&point - data.points.data())];
  }));
  if (below < fewest_below_limit)
    refuse(data,
           fmt::format("needs at least {} rows with a force below the limit, or Young's modulus cannot be told",
                       fewest_below_limit),
           std::to_string(below), "measure at smaller forces");
  const double left = compliance_left(data, at_limit, fit.material.young);
  if (left > noticeable_give)
    result.warnings.push_back(fmt::format(
        "beyond the limit the stretch still grows, at {:.0f} % of the rate below it: the limit stands for a stiffening "
        "that is more gradual",
        100 * left));
}

}  // namespace

MaterialFit fit_material(const Measurements& data, double poisson) {
  FitModel model(data.test);
  return fit_material(data, poisson, model);
}

MaterialFit fit_material(const Measurements& data, double poisson, FitModel& model) {
  Fitter fitter(data, poisson, model);
  const double stiffness_factor = shear_factor(data.test, poisson);
  const double largest_stretch = fitter.largest_stretch();
  Fit unlimited = fitter.start();
  unlimited.material.young = stiffness_factor * largest_stress(data) / largest_stretch;
  const bool bears = fitter.solve(unlimited);
  std::optional<Fit> limited = solve_limited(data, fitter, stiffness_factor);
  if (limited && fitter.lateral()) {
    fitter.weigh_by(*limited);
    fitter.solve(*limited);
    if (bears) fitter.solve(unlimited);
  }
  if (limited && bears && !shows_limit(data, fitter, unlimited, *limited)) limited.reset();
  if (!limited && !bears)
    refuse(data, "deforms further than a specimen of this law can bear",
           fmt::format("a stretch of {:.3g} %", 100 * largest_stretch), "leave out the rows of the largest forces");
  if (limited) {
    MaterialFit result = result_of(data, fitter, *limited, poisson);
    check_limited(data, limited_points(data, model, limited->material), *limited, result);
    return result;
  }
  if (fitter.lateral()) {
    fitter.weigh_by(unlimited);
    fitter.solve(unlimited);
  }
  MaterialFit result = result_of(data, fitter, unlimited, poisson);
  result.limit_bound = limit_bound(fitter, unlimited, data);
  return result;
}

SimulatedTest simulate_test(TestKind test, double young, double poisson, double limit_stretch,
                            const std::vector<double>& stresses) {
  FitModel model(test);
  SimulatedTest simulated;
  for (const double stress : stresses) {
    const auto reading = model.at({young, poisson, limit_stretch}, stress);
    simulated.stretch.push_back(reading ? reading->stretch : std::nan(""));
    simulated.lateral_stretch.push_back(reading && test != TestKind::shear ? reading->lateral_stretch : std::nan(""));
  }
  return simulated;
}

}  // namespace umax
