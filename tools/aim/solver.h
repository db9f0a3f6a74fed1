// Finds the place in a box where all misses are small, in few tries of which each costs a simulation.
//
// One key, one want: the ends and a middle side by side; then, between two tries of which one misses by too much and one by
// too little, the root of the monotone cubic through all tries, and the middle where that does not halve the bracket.
// More of either: Gauss-Newton in the box, its derivatives taken by differences side by side and kept up by Broyden's
// updates, taken anew where a step does not lead closer.
//
// A place is a point of [0, 1]^keys. A miss is (value - wanted) / scale of each want; the tries alone decide, so that the
// result does not depend on how many run at once.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/base/types.h"

namespace umax {

struct AimProblem {
  int num_keys = 1, num_wants = 1;     // up to three of each
  std::optional<VectorXd> start = {};  // the place that the scene has now
  int most_tries = 10;
  double tolerance = 0.01;  // [-] of the largest miss
};

struct AimTry {
  VectorXd place, miss;
};

enum class AimEnd {
  reached,
  stopped,        // tries could not be made
  flat,           // the keys change nothing
  out_of_range,   // the nearest is at an end of a range, and more of the same would lead on
  not_monotone,   // one key: the misses turn round before they get small
  jump,           // one key: from too much to too little at one place
  conflict,       // no step of the keys brings the wants closer together
  too_many_tries  // had been made before it was reached
};

struct AimResult {
  AimEnd end = AimEnd::stopped;
  std::vector<AimTry> tries;        // in their order
  std::size_t best = 0;             // of the tries, the least largest miss
  std::vector<int> keys_at_end;     // out_of_range: which keys are at an end
  bool more_than_one = false;       // one key: several places do it
  std::vector<AimTry> around_jump;  // jump: before and behind it
};

/// The misses at these places, in their order, or nothing when no more tries can be made.
using TryPlaces = std::function<std::optional<std::vector<VectorXd>>(const std::vector<VectorXd>& places)>;

AimResult solve_aim(const AimProblem& problem, const TryPlaces& try_places);

/// The two kinds.
AimResult solve_one_key(const AimProblem& problem, const TryPlaces& try_places);
AimResult solve_several_keys(const AimProblem& problem, const TryPlaces& try_places);

/// The largest of the misses.
double worst_miss(const AimTry& one);

/// Appends the tries; false when they could not be made.
bool make_tries(const std::vector<VectorXd>& places, const TryPlaces& try_places, AimResult& result);

}  // namespace umax
