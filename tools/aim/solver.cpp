#include "tools/aim/solver.h"

namespace umax {

AimResult solve_aim(const AimProblem& problem, const TryPlaces& try_places) {
  if (problem.num_keys == 1 && problem.num_wants == 1) return solve_one_key(problem, try_places);
  return solve_several_keys(problem, try_places);
}

double worst_miss(const AimTry& one) {
  return one.miss.cwiseAbs().maxCoeff();
}

bool make_tries(const std::vector<VectorXd>& places, const TryPlaces& try_places, AimResult& result) {
  const auto misses = try_places(places);
  if (!misses) return false;
  for (std::size_t i = 0; i < places.size(); ++i) {
    result.tries.push_back({places[i], (*misses)[i]});
    if (worst_miss(result.tries.back()) < worst_miss(result.tries[result.best])) result.best = result.tries.size() - 1;
  }
  return true;
}

}  // namespace umax
