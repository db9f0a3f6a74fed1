// The search of umax aim on functions whose answers are known.
#include <cmath>

#include "tests/support/catch.h"
#include "tools/aim/solver.h"

using namespace umax;

namespace {

using Function = std::function<VectorXd(const VectorXd& place)>;

VectorXd list(std::initializer_list<double> values) {
  VectorXd vector(Eigen::Index(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) vector[i++] = value;
  return vector;
}

TryPlaces tries_of(const Function& function) {
  return [function](const std::vector<VectorXd>& places) {
    std::vector<VectorXd> misses;
    for (const VectorXd& place : places) {
      CHECK(place.minCoeff() >= 0);
      CHECK(place.maxCoeff() <= 1);
      misses.push_back(function(place));
    }
    return std::optional(misses);
  };
}

AimResult solve_one(const std::function<double(double)>& miss, std::optional<double> start = std::nullopt) {
  AimProblem problem;
  if (start) problem.start = list({*start});
  return solve_aim(problem, tries_of([&](const VectorXd& place) { return list({miss(place[0])}); }));
}

const AimTry& best_of(const AimResult& result) {
  return result.tries[result.best];
}

AimResult solve(int keys, int wants, const Function& function, std::optional<VectorXd> start = std::nullopt) {
  return solve_aim({.num_keys = keys, .num_wants = wants, .start = std::move(start), .most_tries = 10 * keys},
                   tries_of(function));
}

}  // namespace

TEST_CASE("one key: monotone misses are brought to 1 % in seven tries, wherever the root is", "[aim]") {
  const std::vector<std::function<double(double, double)>> shapes{
      [](double x, double root) { return x - root; },
      [](double x, double root) { return 2 * (root - x); },
      [](double x, double root) { return std::exp(2 * x) - std::exp(2 * root); },
      [](double x, double root) { return std::tanh(3 * x) - std::tanh(3 * root); },
      [](double x, double root) { return x * x * x - root * root * root; },
      [](double x, double root) { return std::sqrt(root + 0.01) - std::sqrt(x + 0.01); }};
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (const double root : {0.07, 0.33, 0.62, 0.94}) {
      CAPTURE(i, root);
      const AimResult result = solve_one([&](double x) { return shapes[i](x, root); }, 0.45);
      CHECK(result.end == AimEnd::reached);
      CHECK(result.tries.size() <= 7);
      CHECK(std::abs(shapes[i](best_of(result).place[0], root)) <= 0.01);
      CHECK(!result.more_than_one);
    }
}

TEST_CASE("one key: the scene's own value is tried first, and is enough where it does", "[aim]") {
  const AimResult result = solve_one([](double x) { return x - 0.3; }, 0.301);
  CHECK(result.end == AimEnd::reached);
  CHECK(result.tries.front().place[0] == 0.301);
  CHECK(result.best == 0);
  CHECK(result.tries.size() == 3);
}

TEST_CASE("one key: misses that nothing changes are flat", "[aim]") {
  const AimResult result = solve_one([](double) { return 0.2; });
  CHECK(result.end == AimEnd::flat);
  CHECK(result.tries.size() == 3);
}

TEST_CASE("one key: what lies beyond an end is out of range, and that end is the nearest", "[aim]") {
  const AimResult below = solve_one([](double x) { return 0.2 + x; });
  CHECK(below.end == AimEnd::out_of_range);
  CHECK(best_of(below).place[0] == 0);
  CHECK(below.keys_at_end == std::vector<int>{0});
  const AimResult above = solve_one([](double x) { return std::tanh(4 * x) - 1.2; }, 0.7);
  CHECK(above.end == AimEnd::out_of_range);
  CHECK(best_of(above).place[0] == 1);
}

TEST_CASE("one key: misses that turn round before they get small are not monotone, and the nearest is near the turn",
          "[aim]") {
  const AimResult result = solve_one([](double x) { return 0.3 + 2 * (x - 0.4) * (x - 0.4); });
  CHECK(result.end == AimEnd::not_monotone);
  CHECK(result.tries.size() <= 10);
  CHECK(std::abs(best_of(result).place[0] - 0.4) < 0.06);
}

TEST_CASE("one key: a root is found although ends and middle miss to the same side", "[aim]") {
  const AimResult result = solve_one([](double x) { return 4 * (x - 0.35) * (x - 0.35) - 0.02; });
  CHECK(result.end == AimEnd::reached);
  CHECK(std::abs(4 * std::pow(best_of(result).place[0] - 0.35, 2) - 0.02) <= 0.01);
}

TEST_CASE("one key: of several roots the one nearest to the scene's own value is found, and that is said", "[aim]") {
  const auto wave = [](double x) { return std::cos(9 * x); };  // roots near 0.175, 0.524, 0.873
  CHECK(solve_one(wave, 0.2).end == AimEnd::reached);
  const auto valley = [](double x) { return std::abs(x - 0.5) - 0.2; };  // 0.3 and 0.7
  for (const auto& [start, root] : {std::pair(0.35, 0.3), std::pair(0.65, 0.7)}) {
    const AimResult result = solve_one(valley, start);
    REQUIRE(result.end == AimEnd::reached);
    CHECK(std::abs(best_of(result).place[0] - root) <= 0.01);
    CHECK(result.more_than_one);
  }
}

TEST_CASE("one key: a jump is told with what is before and behind it", "[aim]") {
  AimProblem problem;
  problem.most_tries = 40;
  const AimResult result = solve_aim(
      problem, tries_of([](const VectorXd& place) { return list({place[0] < 0.37 ? 0.5 + 0.1 * place[0] : -0.25}); }));
  CHECK(result.end == AimEnd::jump);
  REQUIRE(result.around_jump.size() == 2);
  CHECK(result.around_jump[0].place[0] < 0.37);
  CHECK(result.around_jump[1].place[0] >= 0.37);
  CHECK(result.around_jump[1].place[0] - result.around_jump[0].place[0] < 1e-4);
  problem.most_tries = 10;
  CHECK(solve_aim(problem, tries_of([](const VectorXd& place) { return list({place[0] < 0.37 ? 0.5 : -0.25}); })).end ==
        AimEnd::too_many_tries);
}

TEST_CASE("one key: misses that are cut off at 10 do not lead astray", "[aim]") {
  const AimResult result = solve_one([](double x) { return x < 0.6 ? 10 : 3 * (0.8 - x); });
  CHECK(result.end == AimEnd::reached);
  CHECK(result.tries.size() <= 10);
}

TEST_CASE("no more tries than allowed are made, and none once they cannot be made", "[aim]") {
  int count = 0;
  AimProblem problem;
  problem.most_tries = 5;
  const AimResult few = solve_aim(problem, [&](const std::vector<VectorXd>& places) {
    count += int(places.size());
    return std::optional(std::vector<VectorXd>(places.size(), list({places.front()[0] < 0.5 ? -1.0 : 1.0})));
  });
  CHECK(count <= 5);
  CHECK(few.end != AimEnd::reached);
  const AimResult stopped = solve_aim(AimProblem{}, [](const auto&) { return std::nullopt; });
  CHECK(stopped.end == AimEnd::stopped);
  CHECK(stopped.tries.empty());
}

TEST_CASE("two keys and two wants: a known root is reached, with all derivatives tried side by side", "[aim]") {
  const auto misses = [](const VectorXd& x) {
    const double a = x[0] - 0.7, b = x[1] - 0.2;
    return list({1.2 * a + 0.4 * b + 0.5 * a * a, std::exp(0.8 * b) - 1 - 0.3 * a + 0.4 * a * b});
  };
  std::vector<std::size_t> batches;
  const AimProblem problem{.num_keys = 2, .num_wants = 2, .most_tries = 20};
  const AimResult result = solve_aim(problem, [&](const std::vector<VectorXd>& places) {
    batches.push_back(places.size());
    return tries_of(misses)(places);
  });
  CHECK(result.end == AimEnd::reached);
  CHECK(batches.front() == 3);
  CHECK(result.tries.size() <= 8);
  CHECK((best_of(result).place - list({0.7, 0.2})).norm() < 0.03);
}

TEST_CASE("three keys and three wants: a known root is reached", "[aim]") {
  const AimResult result = solve(
      3, 3,
      [](const VectorXd& x) {
        const VectorXd d = x - list({0.3, 0.8, 0.55});
        return list({std::sinh(d[0]) + 0.3 * d[1], d[1] - 0.4 * d[2] + d[0] * d[0], 0.8 * d[2] + 0.2 * d[0]});
      },
      list({0.6, 0.4, 0.5}));
  CHECK(result.end == AimEnd::reached);
  CHECK(result.tries.size() <= 12);
  CHECK((best_of(result).place - list({0.3, 0.8, 0.55})).norm() < 0.05);
}

TEST_CASE("three keys for one want: any place that does it will do", "[aim]") {
  const AimResult result = solve(3, 1, [](const VectorXd& x) { return list({x.squaredNorm() - 1.6}); });
  CHECK(result.end == AimEnd::reached);
  CHECK(std::abs(best_of(result).place.squaredNorm() - 1.6) <= 0.01);
}

TEST_CASE("one key that cannot serve two wants: they contradict each other, and both miss alike at the nearest",
          "[aim]") {
  const AimResult result = solve(1, 2, [](const VectorXd& x) { return list({x[0] - 0.3, x[0] - 0.7}); });
  CHECK(result.end == AimEnd::conflict);
  CHECK(std::abs(best_of(result).place[0] - 0.5) < 0.02);
}

TEST_CASE("several keys: a root outside of the box ends at the nearest place of its side, and says which key",
          "[aim]") {
  const AimResult result = solve(2, 2, [](const VectorXd& x) { return list({x[0] - 1.3, x[1] - 0.4}); });
  CHECK(result.end == AimEnd::out_of_range);
  CHECK(result.keys_at_end == std::vector<int>{0});
  CHECK((best_of(result).place - list({1, 0.4})).norm() < 0.01);
}

TEST_CASE("several keys that change nothing are flat", "[aim]") {
  CHECK(solve(2, 1, [](const VectorXd&) { return list({0.5}); }).end == AimEnd::flat);
}
