#include "tools/reproduce/run_measures.h"

#include <algorithm>
#include <limits>

namespace umax {

int frame_of_least(const Run& run, int first, int last, const std::function<double(const State&)>& measure) {
  int best = first;
  double least = std::numeric_limits<double>::infinity();
  for (int frame = first; frame <= last; ++frame)
    if (const double value = measure(run.state(frame)); value < least) {
      least = value;
      best = frame;
    }
  return best;
}

Vector3d centre_of_mass(const Model& model, const State& state) {
  return state.positions.transpose() * model.node_mass / model.node_mass.sum();
}

Points surface_points(const Run& run, const State& state) {
  const BodySetup& body = run.simulation->bodies.front();
  return deform_points(points_of(*body.embedding), body.lattice.hexes, state.positions);
}

double highest_point(const Run& run, const State& state) {
  return surface_points(run, state).col(1).maxCoeff();
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

int num_unconverged(const Run& run) {
  return int(std::count(run.steps.converged.begin(), run.steps.converged.end(), false));
}

RatioSpread ratio_spread(const VectorXd& ratios) {
  if (ratios.size() == 0) return {};
  std::vector<double> sorted(ratios.begin(), ratios.end());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t middle = sorted.size() / 2;
  RatioSpread spread;
  spread.least = sorted.front();
  spread.largest = sorted.back();
  spread.median = sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
  spread.share_at_limit = double((ratios.array() >= 0.99).count()) / double(ratios.size());
  return spread;
}

}  // namespace umax
