// Materials from measurements: the specimen, the estimates, their intervals.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/catch.h"
#include "tests/tools/error_code_of.h"
#include "tools/fit/least_squares.h"
#include "tools/fit/material_fit.h"
#include "tools/fit/response.h"
#include "tools/fit/student_t.h"

using namespace umax;

namespace {

/// Normally distributed numbers, the same on every machine (Box and Muller).
class Noise {
 public:
  explicit Noise(unsigned seed) : bits_(seed) {}
  double operator()() {
    const double u = uniform(), v = uniform();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
  }

 private:
  double uniform() { return (double(bits_() >> 11) + 0.5) / 9007199254740992.0; }
  std::mt19937_64 bits_;
};

struct Truth {
  TestKind test = TestKind::uniaxial;
  double young = 300e3, poisson = 0.3, limit = 0.2;
};

/// The simulated test as a laboratory without errors would report it.
Measurements measured(const Truth& truth, const SimulatedTest& simulated, const std::vector<double>& stresses) {
  Measurements data{
      .name = "test", .test = truth.test, .points = {}, .has_lateral = false, .reading = {}, .warnings = {}};
  for (std::size_t i = 0; i < stresses.size(); ++i)
    data.points.push_back({.line = int(i) + 2, .stretch = simulated.stretch[i], .stress = stresses[i]});
  return data;
}

std::vector<double> even_stresses(double highest, int count) {
  std::vector<double> stresses;
  for (int i = 1; i <= count; ++i) stresses.push_back(highest * i / count);
  return stresses;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

bool covers(const Estimate& estimate, double truth) {
  return estimate.low <= truth && truth <= estimate.high;
}

struct Recovery {
  std::vector<double> young_errors, limit_errors;  // [-] relative
  int young_covered = 0, limit_covered = 0, without_limit = 0, fewest_at_limit = 1000;
};

/// Fits to the program's own test with 1 % of noise (of the largest stretch, or of each), once for each seed.
Recovery recover(const Truth& truth, double highest_stress, int seeds, bool relative_noise) {
  constexpr int count = 50;
  const std::vector<double> stresses = even_stresses(highest_stress, count);
  const SimulatedTest clean = simulate_test(truth.test, truth.young, truth.poisson, truth.limit, stresses);
  FitModel model(truth.test);
  Recovery recovery;
  for (int seed = 1; seed <= seeds; ++seed) {
    Measurements data = measured(truth, clean, stresses);
    Noise noise{unsigned(seed)};
    double largest = 0;
    for (const MeasuredPoint& point : data.points) largest = std::max(largest, std::abs(point.stretch));
    for (MeasuredPoint& point : data.points)
      point.stretch += 0.01 * (relative_noise ? point.stretch : largest) * noise();
    const MaterialFit fit = fit_material(data, truth.poisson, model);
    recovery.young_errors.push_back(std::abs(fit.young.value / truth.young - 1));
    recovery.young_covered += covers(fit.young, truth.young);
    if (!fit.limit) {
      ++recovery.without_limit;
      continue;
    }
    recovery.fewest_at_limit = std::min(recovery.fewest_at_limit, fit.points_at_limit);
    recovery.limit_errors.push_back(std::abs(fit.limit->value / truth.limit - 1));
    recovery.limit_covered += covers(*fit.limit, truth.limit);
  }
  return recovery;
}

void check_recovery(const Truth& truth, double highest_stress) {
  constexpr int seeds = 20;
  for (const bool relative_noise : {false, true}) {
    const Recovery recovery = recover(truth, highest_stress, seeds, relative_noise);
    CAPTURE(test_name(truth.test), relative_noise);
    REQUIRE(recovery.without_limit == 0);
    CHECK(recovery.fewest_at_limit >= 10);
    CHECK(median(recovery.young_errors) < 0.02);
    CHECK(median(recovery.limit_errors) < 0.02);
    // binomial: fewer than 16 of 20 have a chance of 0.3 % at 95 %
    CHECK(recovery.young_covered >= 16);
    CHECK(recovery.limit_covered >= 16);
  }
}

}  // namespace

TEST_CASE("a specimen in tension or compression follows Hooke's law up to its limit and no further") {
  for (const Loading loading : {Loading::tension, Loading::compression})
    for (const double poisson : {0.0, 0.3, 0.45}) {
      Specimen specimen({.loading = loading, .poisson = poisson, .limit_stretch = 0.2});
      const double sign = loading == Loading::tension ? 1 : -1;
      for (const double load : {0.01, 0.1, 0.199, 0.21, 0.5, 3.0}) {
        CAPTURE(poisson, load, sign);
        const auto reading = specimen.at(load);
        REQUIRE(reading);
        const double stretch = std::min(load, 0.2);
        CHECK(std::abs(sign * reading->stretch / stretch - 1) < 1e-6);
        CHECK(std::abs(-sign * reading->lateral_stretch - poisson * stretch) < 1e-7);
        CHECK(std::abs(reading->peak_stretch / stretch - 1) < 1e-6);
      }
    }
}

TEST_CASE("a specimen is compressed to a fifth without toppling") {
  for (const double poisson : {0.0, 0.3, 0.45}) {
    Specimen specimen({.loading = Loading::compression, .poisson = poisson});
    for (const double load : {0.4, 0.6, 0.8}) {
      CAPTURE(poisson, load);
      const auto reading = specimen.at(load);
      REQUIRE(reading);
      CHECK(std::abs(reading->stretch / -load - 1) < 1e-6);
    }
  }
}

TEST_CASE("a sheared specimen has the shear modulus of its material, and the shear that its limit allows") {
  for (const double poisson : {0.0, 0.3, 0.45}) {
    Specimen specimen({.loading = Loading::shear, .poisson = poisson, .limit_stretch = 0.05});
    const double compliance = 2 * (1 + poisson);
    const auto small = specimen.at(0.001), locked = specimen.at(1);
    REQUIRE(small);
    REQUIRE(locked);
    CHECK(std::abs(small->stretch / (0.001 * compliance) - 1) < 1e-4);
    // engineering shear of the limit's energy, s sqrt(2 (1 + nu)), a little less in finite shear
    CHECK(std::abs(locked->stretch / (0.05 * std::sqrt(compliance)) - 1) < 5e-3);
  }
}

TEST_CASE("a specimen that was overloaded is as it was, and goes on") {
  Specimen specimen({.loading = Loading::compression, .poisson = 0.3});
  const auto before = specimen.at(0.2);
  CHECK(!specimen.at(1.5));
  const auto after = specimen.at(0.2);
  REQUIRE(before);
  REQUIRE(after);
  CHECK(std::abs(after->stretch - before->stretch) < 1e-8);
}

TEST_CASE("interpolated responses are those of the simulated specimens") {
  for (const Loading loading : {Loading::tension, Loading::compression, Loading::shear})
    for (const double limit : {0.07, 0.23}) {
      Response response(loading, 0.4);
      for (const double load : {0.0131, 0.11, 0.17, 0.29, 0.41, 1.7}) {
        CAPTURE(int(loading), limit, load);
        Specimen specimen({.loading = loading, .poisson = 0.4, .limit_stretch = limit});
        const auto simulated = specimen.at(load);
        const auto interpolated = response.at(load, limit);
        REQUIRE(simulated);
        REQUIRE(interpolated);
        CHECK(std::abs(interpolated->stretch / simulated->stretch - 1) < 1e-3);
        CHECK(std::abs(interpolated->lateral_stretch - simulated->lateral_stretch) < 1e-4);
      }
    }
}

TEST_CASE("Student's t has its tabulated quantiles") {
  CHECK(student_t_quantile(0.975, 1) == Approx(12.7062).epsilon(1e-5));
  CHECK(student_t_quantile(0.975, 2) == Approx(4.30265).epsilon(1e-5));
  CHECK(student_t_quantile(0.975, 10) == Approx(2.22814).epsilon(1e-5));
  CHECK(student_t_quantile(0.95, 7) == Approx(1.89458).epsilon(1e-5));
  CHECK(student_t_quantile(0.025, 48) == Approx(-2.01063).epsilon(1e-5));
  CHECK(student_t_quantile(0.5, 5) == Approx(0).margin(1e-9));
}

TEST_CASE("least squares of a line are those of the normal equations") {
  const std::vector<double> x{0, 1, 2, 3, 4}, y{1.1, 2.9, 5.2, 7.1, 8.8};
  LeastSquaresProblem problem;
  problem.num_residuals = 5;
  problem.residuals = [&](const double* p, double* r) {
    for (std::size_t i = 0; i < x.size(); ++i) r[i] = p[0] + p[1] * x[i] - y[i];
    return true;
  };
  problem.start = {10, -3};
  problem.low = {-100, -100};
  problem.high = {100, 100};
  const LeastSquaresSolution solution = solve_least_squares(problem);
  REQUIRE(solution.converged);
  CHECK(solution.parameters[0] == Approx(1.10).margin(1e-8));
  CHECK(solution.parameters[1] == Approx(1.96).margin(1e-8));
  CHECK(solution.covariance(0, 0) == Approx(0.6).epsilon(1e-6));
  CHECK(solution.covariance(1, 1) == Approx(0.1).epsilon(1e-6));
  CHECK(solution.covariance(0, 1) == Approx(-0.2).epsilon(1e-6));
}

TEST_CASE("least squares stay where there are residuals") {
  LeastSquaresProblem problem;
  problem.num_residuals = 1;
  problem.residuals = [](const double* p, double* r) {
    r[0] = p[0] - 2;
    return p[0] < 1.5;
  };
  problem.low = {-100};
  problem.high = {100};
  problem.start = {1};
  const LeastSquaresSolution solution = solve_least_squares(problem);
  CHECK(solution.parameters[0] < 1.5);
  problem.start = {1.7};
  CHECK(!solve_least_squares(problem).converged);
}

TEST_CASE("fits recover modulus and limit from noisy tests of their own, and their intervals hold them") {
  check_recovery({.test = TestKind::uniaxial, .young = 300e3, .limit = 0.2}, 300e3 * 0.2 * 1.35);
  check_recovery({.test = TestKind::compression, .young = 40e3, .limit = 0.12}, -40e3 * 0.12 * 1.35);
  check_recovery({.test = TestKind::shear, .young = 2e6, .poisson = 0.45, .limit = 0.15},
                 2e6 * 0.15 / std::sqrt(2 * 1.45) * 1.4);
}

TEST_CASE("the intervals hold the truth in 95 of 100 fits", "[slow]") {
  for (const bool relative_noise : {false, true}) {
    const Recovery recovery = recover({}, 300e3 * 0.2 * 1.35, 400, relative_noise);
    // binomial with 400 fits: three standard deviations are 3.3 %
    for (const int covered : {recovery.young_covered, recovery.limit_covered}) {
      CAPTURE(relative_noise, covered);
      CHECK(covered >= 367);
      CHECK(covered <= 393);
    }
  }
}

TEST_CASE("a limit that no row reaches is bounded from below") {
  const Truth truth;
  FitModel model(truth.test);
  for (const double share : {0.5, 0.9}) {
    const std::vector<double> stresses = even_stresses(share * truth.young * truth.limit, 50);
    Measurements data = measured(truth, simulate_test(truth.test, truth.young, 0.3, truth.limit, stresses), stresses);
    int below_truth = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      Measurements noisy = data;
      Noise noise(seed);
      for (MeasuredPoint& point : noisy.points) point.stretch += 0.01 * share * truth.limit * noise();
      const MaterialFit fit = fit_material(noisy, 0.3, model);
      CAPTURE(share, seed);
      CHECK(!fit.limit);
      CHECK(fit.limit_bound > 0.93 * share * truth.limit);
      CHECK(fit.limit_bound < 1.03 * share * truth.limit);
      below_truth += fit.limit_bound <= truth.limit;
    }
    CHECK(below_truth == 20);
  }
}

TEST_CASE("lateral stretches tell Poisson's ratio") {
  const Truth truth{.young = 80e3, .poisson = 0.42, .limit = 0.15};
  const std::vector<double> stresses = even_stresses(80e3 * 0.15 * 1.35, 50);
  const SimulatedTest clean = simulate_test(truth.test, truth.young, truth.poisson, truth.limit, stresses);
  FitModel model(truth.test);
  std::vector<double> errors;
  int covered = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Measurements data = measured(truth, clean, stresses);
    data.has_lateral = true;
    Noise noise(seed);
    for (std::size_t i = 0; i < data.points.size(); ++i) {
      data.points[i].stretch += 0.01 * 0.15 * noise();
      if (i % 3 != 0) data.points[i].lateral_stretch = clean.lateral_stretch[i] + 0.02 * 0.15 * noise();
    }
    const MaterialFit fit = fit_material(data, 0.3, model);
    REQUIRE(fit.poisson);
    REQUIRE(fit.limit);
    errors.push_back(std::abs(fit.poisson->value / truth.poisson - 1));
    covered += covers(*fit.poisson, truth.poisson);
  }
  CHECK(median(errors) < 0.02);
  CHECK(covered >= 16);
}

TEST_CASE("a bend that goes on rising is no limit, or one that is said to give") {
  Measurements stiffening{
      .name = "bend", .test = TestKind::uniaxial, .points = {}, .has_lateral = false, .reading = {}, .warnings = {}};
  Measurements softening = stiffening;
  for (int i = 1; i <= 50; ++i) {
    const double stress = 2e3 * i, elastic = stress / 100e3, knee = 0.3;
    const double kept = elastic < knee ? elastic : knee + 0.3 * (elastic - knee);
    stiffening.points.push_back({.line = i, .stretch = kept + 1e-3 * ((i * 7) % 5 - 2), .stress = stress});
    softening.points.push_back({.line = i, .stretch = elastic + 0.5 * elastic * elastic, .stress = stress});
  }
  const MaterialFit stiff = fit_material(stiffening, 0.3);
  CHECK(stiff.limit);
  CHECK(!stiff.warnings.empty());
  const MaterialFit soft = fit_material(softening, 0.3);
  CHECK(!soft.limit);
  CHECK(!soft.warnings.empty());  // residuals that are no noise
}

TEST_CASE("data that are all at the limit do not tell the modulus") {
  Measurements data{
      .name = "all", .test = TestKind::uniaxial, .points = {}, .has_lateral = false, .reading = {}, .warnings = {}};
  Noise noise(3);
  for (int i = 0; i < 12; ++i)
    data.points.push_back({.line = i + 2, .stretch = 0.2 + 0.001 * noise(), .stress = 100e3 + 20e3 * i});
  CHECK(error_code_of([&] { fit_material(data, 0.3); }) == 65);
}
