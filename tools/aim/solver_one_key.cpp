#include <algorithm>
#include <cmath>

#include "tools/aim/solver.h"

namespace umax {
namespace {

constexpr double least_bracket = 1e-4;   // [-] of the range: what changes within it jumps
constexpr double flat = 1e-3;            // [-] misses that differ by less are the same
constexpr double near_enough = 0.3;      // [-] of the range, for three tries that tell where misses turn round
constexpr double hardly = 0.05;          // [-] of the best miss
constexpr double least_interval = 0.02;  // [-] of the range, beside the best try when none brackets
constexpr double margin = 0.02;          // [-] of a bracket, by which a try stays inside
constexpr double from_ends = 0.1;        // [-] of the range: a start that is nearer to an end is no middle

struct Point {
  double place, miss;
};

VectorXd place_at(double at) {
  return VectorXd::Constant(1, at);
}

/// The tries from left to right.
std::vector<Point> points_of(const AimResult& result) {
  std::vector<Point> points;
  for (const AimTry& one : result.tries) points.push_back({one.place[0], one.miss[0]});
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.place < b.place; });
  return points;
}

std::vector<VectorXd> first_places(const AimProblem& problem) {
  std::vector<VectorXd> places;
  const double start = problem.start ? (*problem.start)[0] : 0.5;
  if (problem.start) places.push_back(place_at(start));
  if (start != 0) places.push_back(place_at(0));
  if (start != 1) places.push_back(place_at(1));
  if (!problem.start || start < from_ends || start > 1 - from_ends) places.push_back(place_at(0.5));
  return places;
}

/// Slope at a point such that the cubics through the points do not overshoot: the harmonic mean of those beside it (F.
/// N. Fritsch and J. Butland, A Method for Constructing Local Monotone Piecewise Cubic Interpolants, 1984).
double slope_at(const std::vector<Point>& points, std::size_t i) {
  const auto between = [&](std::size_t a) {
    return (points[a + 1].miss - points[a].miss) / (points[a + 1].place - points[a].place);
  };
  if (i == 0) return between(0);
  if (i + 1 == points.size()) return between(i - 1);
  const double left = between(i - 1), right = between(i);
  return left * right <= 0 ? 0 : 2 * left * right / (left + right);
}

/// Where the cubic between points i and i + 1 is zero; their misses have different signs.
double root_between(const std::vector<Point>& points, std::size_t i) {
  const Point &a = points[i], &b = points[i + 1];
  const double width = b.place - a.place, slope_a = slope_at(points, i) * width,
               slope_b = slope_at(points, i + 1) * width;
  const auto cubic = [&](double t) {
    const double u = 1 - t;
    return a.miss * u * u * (1 + 2 * t) + slope_a * t * u * u + b.miss * t * t * (1 + 2 * u) - slope_b * t * t * u;
  };
  double low = 0, high = 1;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (cubic(middle) * a.miss > 0 ? low : high) = middle;
  }
  return a.place + std::clamp(low, margin, 1 - margin) * width;
}

/// Brackets, by their left points.
std::vector<std::size_t> brackets_of(const std::vector<Point>& points) {
  std::vector<std::size_t> brackets;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if (points[i].miss * points[i + 1].miss <= 0) brackets.push_back(i);
  return brackets;
}

/// Whether the best is at an end of the range, and the misses grow from there over the next two tries.
bool leads_out(const std::vector<Point>& points, std::size_t best) {
  const std::size_t last = points.size() - 1;
  if (best != 0 && best != last) return false;
  const auto miss = [&](std::size_t i) { return std::abs(points[best == 0 ? i : last - i].miss); };
  return miss(0) <= miss(1) && miss(1) <= miss(2);
}

/// Whether the parabola through the best and its neighbours, near enough to it, gets hardly any nearer.
bool is_turn(const std::vector<Point>& points, std::size_t best) {
  if (best == 0 || best + 1 == points.size()) return false;
  const Point &a = points[best - 1], &b = points[best], &c = points[best + 1];
  const double left = (b.miss - a.miss) / (b.place - a.place), right = (c.miss - b.miss) / (c.place - b.place);
  const double bend = (right - left) / (c.place - a.place);
  const double slope = left + bend * (b.place - a.place);  // at the best
  const double gain = bend == 0 ? 0 : std::abs(slope * slope / (4 * bend));
  return c.place - a.place < near_enough && gain < hardly * std::abs(b.miss);
}

/// Narrows a bracket until a try is near enough.
class Search {
 public:
  Search(const AimProblem& problem, const TryPlaces& try_places) : problem_(problem), try_places_(try_places) {}

  AimResult run() {
    if (!make_tries(first_places(problem_), try_places_, result_)) return result_;
    while (true) {
      if (worst_miss(result_.tries[result_.best]) <= problem_.tolerance) return ended(AimEnd::reached);
      const std::vector<Point> points = points_of(result_);
      const std::vector<std::size_t> brackets = brackets_of(points);
      result_.more_than_one = brackets.size() > 1;
      const auto next = brackets.empty() ? beside_best(points) : inside(points, nearest(points, brackets));
      if (!next) return result_;
      if (int(result_.tries.size()) >= problem_.most_tries)
        return ended(brackets.empty() ? AimEnd::not_monotone : AimEnd::too_many_tries);
      if (!make_tries({place_at(*next)}, try_places_, result_)) return ended(AimEnd::stopped);
    }
  }

 private:
  AimResult ended(AimEnd end) {
    result_.end = end;
    return result_;
  }

  /// The bracket whose root, by the straight line, is nearest to the scene's own value.
  std::size_t nearest(const std::vector<Point>& points, const std::vector<std::size_t>& brackets) const {
    const double start = problem_.start ? (*problem_.start)[0] : 0.5;
    const auto distance = [&](std::size_t i) {
      const Point &a = points[i], &b = points[i + 1];
      const double share = a.miss == b.miss ? 0.5 : a.miss / (a.miss - b.miss);
      return std::abs(a.place + share * (b.place - a.place) - start);
    };
    return *std::min_element(brackets.begin(), brackets.end(),
                             [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
  }

  std::optional<double> inside(const std::vector<Point>& points, std::size_t i) {
    const double width = points[i + 1].place - points[i].place;
    if (width < least_bracket) {
      ended(AimEnd::jump);
      for (const Point& point : {points[i], points[i + 1]})
        result_.around_jump.push_back({place_at(point.place), VectorXd::Constant(1, point.miss)});
      return std::nullopt;
    }
    widths_.push_back(width);
    const bool is_slow = widths_.size() > 2 && width > 0.5 * widths_[widths_.size() - 3];
    return is_slow ? points[i].place + 0.5 * width : root_between(points, i);
  }

  /// All tries miss to the same side: nearer to nothing beyond an end, or between tries where the misses turn round.
  std::optional<double> beside_best(const std::vector<Point>& points) {
    const auto nearer = [](const Point& a, const Point& b) { return std::abs(a.miss) < std::abs(b.miss); };
    const auto [nearest, farthest] = std::minmax_element(points.begin(), points.end(), nearer);
    const std::size_t best = std::size_t(nearest - points.begin());
    const double left = best > 0 ? points[best].place - points[best - 1].place : 0;
    const double right = best + 1 < points.size() ? points[best + 1].place - points[best].place : 0;
    if (std::abs(farthest->miss - nearest->miss) < flat) {
      ended(AimEnd::flat);
    } else if (leads_out(points, best)) {
      result_.keys_at_end = {0};
      ended(AimEnd::out_of_range);
    } else if (std::max(left, right) < least_interval || is_turn(points, best)) {
      ended(AimEnd::not_monotone);
    } else {
      return points[best].place + (right > left ? 0.5 * right : -0.5 * left);
    }
    return std::nullopt;
  }

  const AimProblem& problem_;
  const TryPlaces& try_places_;
  AimResult result_;
  std::vector<double> widths_;  // of brackets
};

}  // namespace

AimResult solve_one_key(const AimProblem& problem, const TryPlaces& try_places) {
  return Search(problem, try_places).run();
}

}  // namespace umax
