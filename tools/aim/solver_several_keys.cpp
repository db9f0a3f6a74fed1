#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "tools/aim/solver.h"

namespace umax {
namespace {

constexpr double first_difference = 0.25;                // [-] of a range
constexpr double least_difference = 0.02;                // likewise
constexpr double first_reach = 0.5, least_reach = 1e-3;  // [-] of a range: how far a step may go
constexpr double least_change = 1e-3;                    // [-] misses that change by less do not change
constexpr double at_end = 1e-9;                          // [-] of a range

/// The step within [low, high] after which |miss + slopes step|^2 is least, by trying which keys end at which bound; of
/// many such steps about the shortest.
VectorXd bounded_step(const MatrixXd& slopes, const VectorXd& miss, const VectorXd& low, const VectorXd& high) {
  const int n = int(slopes.cols());
  const double damping = 1e-6 * std::max(slopes.squaredNorm(), 1e-12);
  VectorXd best = VectorXd::Zero(n);
  double least = std::numeric_limits<double>::infinity();
  for (int pattern = 0; pattern < int(std::pow(3, n)); ++pattern) {
    VectorXd step = VectorXd::Zero(n);
    std::vector<int> open;
    for (int k = 0, digits = pattern; k < n; ++k, digits /= 3) {
      if (digits % 3 == 0) open.push_back(k);
      if (digits % 3 != 0) step[k] = digits % 3 == 1 ? low[k] : high[k];
    }
    if (!open.empty()) {
      const MatrixXd part = slopes(Eigen::all, open);
      MatrixXd normal = part.transpose() * part;
      normal.diagonal().array() += damping;
      step(open) = -normal.ldlt().solve(part.transpose() * (miss + slopes * step));
    }
    if ((step - low).minCoeff() < -1e-12 || (high - step).minCoeff() < -1e-12) continue;
    const double left = (miss + slopes * step).squaredNorm() + damping * step.squaredNorm();
    if (left < least) least = left, best = step;
  }
  return best;
}

class Descent {
 public:
  Descent(const AimProblem& problem, const TryPlaces& try_places) : problem_(problem), try_places_(try_places) {}

  AimResult run() {
    const VectorXd start = problem_.start ? *problem_.start : VectorXd::Constant(problem_.num_keys, 0.5);
    if (!take_slopes(start, first_difference, true)) return result_;
    if (slopes_.cwiseAbs().maxCoeff() < least_change && !is_reached()) return ended(AimEnd::flat);
    while (!is_reached()) {
      const VectorXd step = next_step();
      const double now = best().miss.norm(), hoped = (best().miss + slopes_ * step).norm();
      const bool hopeless = step.cwiseAbs().maxCoeff() < least_reach || hoped > 0.99 * now;
      if (hopeless && are_fresh_) return ended(end_of_hope());
      const int wanted = hopeless || reach_ < least_reach ? problem_.num_keys : 1;
      if (int(result_.tries.size()) + wanted > problem_.most_tries) return ended(AimEnd::too_many_tries);
      if (hopeless || reach_ < least_reach) {
        if (!take_slopes(best().place, std::clamp(reach_, least_difference, 0.1), false)) return result_;
      } else if (!go(step, hoped)) {
        return result_;
      }
    }
    return ended(AimEnd::reached);
  }

 private:
  AimResult ended(AimEnd end) {
    result_.end = end;
    return result_;
  }

  bool is_reached() const { return worst_miss(result_.tries[result_.best]) <= problem_.tolerance; }

  const AimTry& best() const { return result_.tries[best_]; }

  void remember_if_better(std::size_t index) {
    if (result_.tries[index].miss.norm() < best().miss.norm()) best_ = index;
  }

  /// The derivatives at a place by differences, all side by side; first: with the place itself.
  bool take_slopes(VectorXd place, double difference, bool first) {
    std::vector<VectorXd> places;
    if (first) places.push_back(place);
    for (int k = 0; k < problem_.num_keys; ++k) {
      places.push_back(place);
      places.back()[k] += place[k] > 0.5 ? -difference : difference;
    }
    const std::size_t begin = result_.tries.size();
    if (!make_tries(places, try_places_, result_)) return false;
    const VectorXd miss = first ? result_.tries[begin].miss : best().miss;
    slopes_.resize(problem_.num_wants, problem_.num_keys);
    for (int k = 0; k < problem_.num_keys; ++k) {
      const AimTry& beside = result_.tries[begin + std::size_t(k) + (first ? 1 : 0)];
      slopes_.col(k) = (beside.miss - miss) / (beside.place[k] - place[k]);
    }
    for (std::size_t i = begin; i < result_.tries.size(); ++i) remember_if_better(i);
    are_fresh_ = true;
    reach_ = std::max(reach_, 2 * difference);
    return true;
  }

  VectorXd next_step() const {
    const VectorXd low = (-best().place.array()).max(-reach_), high = (1 - best().place.array()).min(reach_);
    return bounded_step(slopes_, best().miss, low, high);
  }

  /// Tries a step, and learns from it.
  bool go(const VectorXd& step, double hoped) {
    const AimTry from = best();
    const VectorXd place = (from.place + step).cwiseMax(0).cwiseMin(1);
    if (!make_tries({place}, try_places_, result_)) return false;
    const AimTry& to = result_.tries.back();
    const VectorXd moved = to.place - from.place;
    slopes_ += (to.miss - from.miss - slopes_ * moved) * moved.transpose() / moved.squaredNorm();
    const double now = from.miss.norm(), share = (now - to.miss.norm()) / (now - hoped);
    if (share < 0.25) reach_ = 0.5 * step.cwiseAbs().maxCoeff();
    if (share > 0.75) reach_ = std::min(1.0, 2 * reach_);
    remember_if_better(result_.tries.size() - 1);
    are_fresh_ = false;
    return true;
  }

  AimEnd end_of_hope() {
    for (int k = 0; k < problem_.num_keys; ++k)
      if (best().place[k] <= at_end || best().place[k] >= 1 - at_end) result_.keys_at_end.push_back(k);
    return result_.keys_at_end.empty() ? AimEnd::conflict : AimEnd::out_of_range;
  }

  const AimProblem& problem_;
  const TryPlaces& try_places_;
  AimResult result_;
  MatrixXd slopes_;       // #wants x #keys
  std::size_t best_ = 0;  // of the tries, the least sum of squares
  double reach_ = first_reach;
  bool are_fresh_ = false;  // slopes by differences at the best place or beside it
};

}  // namespace

AimResult solve_several_keys(const AimProblem& problem, const TryPlaces& try_places) {
  return Descent(problem, try_places).run();
}

}  // namespace umax
