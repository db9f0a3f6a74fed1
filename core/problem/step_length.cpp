#include "core/problem/step_length.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr double bearable_distortion = 0.2;  // [cells]
constexpr double watched_share = 0.5;        // of that, from which easing other hexes may bring one beyond it
constexpr double few = 0.02;                 // of the hexes: where more are distorted that much, the step is to blame
constexpr int distortion_sweeps = 40;
constexpr double same_direction = 0.95;   // cosine between steps of one motion
constexpr double worth_correcting = 0.4;  // [-] of the curvature that the matrix has
constexpr double largest_correction = 8;  // times the step
constexpr double large_move = 0.2;        // [cells] smaller steps may be leaving a saddle, slowly at first
constexpr std::size_t patience = 4;       // iterations; twice as many where steps do not undo each other
constexpr double slow_fall = 0.5;         // of the residual, in as many
constexpr double careful_share = 0.5;     // of a step where it hardly falls
constexpr double nearly_whole = 0.9;      // share of a step: a few hexes that are eased may cost a little of it
constexpr Eigen::Index hexes_per_block = 64;

// [cells^2] of the node that moves farthest from the hex's mean motion
double squared_distortion(const Model& model, const VectorXd& step, Eigen::Index hex) {
  Matrix8x3d moves;
  for (int n = 0; n < 8; ++n) moves.row(n) = step.segment<3>(3 * model.hexes(hex, n)).transpose();
  moves.rowwise() -= moves.colwise().mean().eval();
  const double size = body_of(model, hex).cell_size;
  return moves.rowwise().squaredNorm().maxCoeff() / (size * size);
}

std::vector<int> hexes_beyond(const Model& model, const VectorXd& step, double distortion) {
  std::vector<std::vector<int>> of_blocks((model.num_hexes() + hexes_per_block - 1) / hexes_per_block);
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e)
      if (squared_distortion(model, step, e) > distortion * distortion)
        of_blocks[begin / hexes_per_block].push_back(int(e));
  });
  std::vector<int> hexes;
  for (const std::vector<int>& block : of_blocks) hexes.insert(hexes.end(), block.begin(), block.end());
  return hexes;
}

// adds to the changes of the hex's free nodes what brings them nearer to its mean motion, by a share of the distance
void pull_together(const Model& model, const VectorXd& step, int hex, double share, std::vector<int>& nodes,
                   Points& changes, VectorXi& changed_by) {
  Vector3d mean = Vector3d::Zero();
  for (int n = 0; n < 8; ++n) mean += step.segment<3>(3 * model.hexes(hex, n)) / 8;
  for (int n = 0; n < 8; ++n) {
    const int node = model.hexes(hex, n);
    if (model.node_fixed[node]) continue;
    if (changed_by[node]++ == 0) nodes.push_back(node);
    changes.row(node) += share * (mean - step.segment<3>(3 * node)).transpose();
  }
}

// Has the residual hardly fallen in the last iterations? The first ones, which look for contacts, do not count. The least
// ones tell, before and since: an iteration that goes in a circle has good ones in between.
bool hardly_falls(const std::vector<double>& residuals, std::size_t iterations) {
  if (residuals.size() <= iterations + patience) return false;
  const auto last = residuals.end() - std::ptrdiff_t(iterations);
  return *std::min_element(last, residuals.end()) >
         slow_fall * *std::min_element(residuals.begin() + std::ptrdiff_t(patience), last);
}

// a body's part of a step
template <class Step>
auto part_of(const Model::BodyRange& body, Step& step) {
  return step.segment(3 * body.first_node, 3 * body.num_nodes);
}

double largest_move(const Model::BodyRange& body, const Eigen::Ref<const VectorXd>& part) {
  double largest = 0;
  for (int node = 0; node < body.num_nodes; ++node)
    largest = std::max(largest, part.segment<3>(3 * node).norm() / body.cell_size);
  return largest;
}

// how much of its part of a step a body would take, were all of it bearable, and more than all as well
double wanted_factor(const Model::BodyRange& body, const VectorXd& part, const std::vector<double>& residuals,
                     const TakenStep& before) {
  const double factor = correction(part, before);
  if (goes_to_and_fro(residuals, part, before)) return std::min(careful_share, factor);
  if (factor == 1 && stagnates(residuals) && largest_move(body, part) > large_move) return careful_share;
  return factor;
}

}  // namespace

double largest_move(const Model& model, const VectorXd& step) {
  double largest = 0;
  for (const Model::BodyRange& body : model.bodies)
    largest = std::max(largest, largest_move(body, part_of(body, step)));
  return largest;
}

VectorXd step_fractions(const Model& model, const VectorXd& step) {
  VectorXd fractions(Eigen::Index(model.bodies.size()));
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Model::BodyRange& body = model.bodies[b];
    VectorXd largest = VectorXd::Zero((body.num_hexes + hexes_per_block - 1) / hexes_per_block);  // squared [cells]
    parallel_blocks(body.num_hexes, hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
      double& most = largest[begin / hexes_per_block];
      for (Eigen::Index e = begin; e < end; ++e)
        most = std::max(most, squared_distortion(model, step, body.first_hex + e));
    });
    fractions[Eigen::Index(b)] =
        largest.size() ? std::min(1.0, bearable_distortion / std::sqrt(largest.maxCoeff())) : 1;
  }
  return fractions;
}

double max_step_fraction(const Model& model, const VectorXd& step) {
  return step_fractions(model, step).minCoeff();
}

void limit_distortion(const Model& model, VectorXd& step) {
  const std::vector<int> hexes = hexes_beyond(model, step, watched_share * bearable_distortion);
  const auto beyond = std::count_if(hexes.begin(), hexes.end(), [&](int hex) {
    return squared_distortion(model, step, hex) > bearable_distortion * bearable_distortion;
  });
  if (beyond == 0 || double(beyond) > few * double(model.num_hexes())) return;
  const auto count = Eigen::Index(hexes.size());
  VectorXd distortions(count);
  Points changes = Points::Zero(model.num_nodes(), 3);
  VectorXi changed_by = VectorXi::Zero(model.num_nodes());  // hexes
  for (int sweep = 0; sweep < distortion_sweeps; ++sweep) {
    parallel_blocks(count, hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) distortions[i] = std::sqrt(squared_distortion(model, step, hexes[i]));
    });
    std::vector<int> nodes;  // of hexes that are beyond
    for (Eigen::Index i = 0; i < count; ++i)
      if (distortions[i] > bearable_distortion)
        pull_together(model, step, hexes[i], 1 - bearable_distortion / distortions[i], nodes, changes, changed_by);
    if (nodes.empty()) return;
    for (const int node : nodes) {
      step.segment<3>(3 * node) += changes.row(node).transpose() / changed_by[node];
      changes.row(node).setZero();
      changed_by[node] = 0;
    }
  }
}

TakenStep taken_step(VectorXd step, double factor) {
  return factor >= careful_share ? TakenStep{std::move(step), factor} : TakenStep{};
}

std::vector<TakenStep> taken_steps(const Model& model, const VectorXd& step, const VectorXd& shares) {
  std::vector<TakenStep> taken;
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    taken.push_back(taken_step(part_of(model.bodies[b], step), shares[Eigen::Index(b)]));
  return taken;
}

double correction(const VectorXd& step, const TakenStep& before) {
  if (before.step.isZero(0)) return 1;  // there was none, or the body is held as a whole
  const double along = step.dot(before.step), square = before.step.squaredNorm();
  if (std::abs(along) < same_direction * step.norm() * before.step.norm()) return 1;
  const double curvature = (1 - along / square) / before.factor;  // [-] the true one over the matrix's
  return std::abs(1 - curvature) < worth_correcting ? 1 : 1 / std::max(curvature, 1 / largest_correction);
}

bool goes_to_and_fro(const std::vector<double>& residuals, const VectorXd& step, const TakenStep& before) {
  return before.step.size() > 0 && hardly_falls(residuals, patience) && step.dot(before.step) < 0;
}

bool stagnates(const std::vector<double>& residuals) {
  return hardly_falls(residuals, 2 * patience);
}

VectorXd step_factors(const Model& model, const VectorXd& step, double bearable, bool balanced,
                      const std::vector<double>& residuals, const std::vector<TakenStep>& before) {
  const auto count = Eigen::Index(model.bodies.size());
  if (balanced || bearable < nearly_whole) return VectorXd::Constant(count, bearable);
  VectorXd factors(count);
  for (Eigen::Index b = 0; b < count; ++b) {
    const Model::BodyRange& body = model.bodies[std::size_t(b)];
    factors[b] =
        wanted_factor(body, part_of(body, step), residuals, before.empty() ? TakenStep{} : before[std::size_t(b)]);
  }
  if ((factors.array() <= 1).all()) return factors.cwiseMin(bearable);
  VectorXd extended = step;
  for (Eigen::Index b = 0; b < count; ++b) part_of(model.bodies[std::size_t(b)], extended) *= factors[b];
  const VectorXd fractions = step_fractions(model, extended);
  return (factors.array() > 1).select(factors.cwiseProduct(fractions), factors.cwiseMin(bearable));
}

}  // namespace umax
