#include "core/problem/body_shares.h"

#include <algorithm>
#include <cmath>

#include "core/base/groups.h"
#include "core/contact/surface_contact.h"
#include "core/problem/step_length.h"

namespace umax {
namespace {

VectorXd approaches(const StepProblem& problem, const Points& from, const Points& to) {
  const ContactGeometry& geometry = *problem.contact.geometry;
  return largest_approaches(*problem.model, geometry.touchable, geometry.hex_starts, from, to);
}

// the least share of each group of bodies that push each other
void share_alike(const StepProblem& problem, const Iterate& iterate, VectorXd& shares) {
  Groups groups(std::size_t(shares.size()));
  for (const Contact& contact : iterate.contacts)
    if (contact.between_bodies() && !contact.force.isZero(0)) {
      const auto [first, second] = bodies_of(*problem.model, contact);
      groups.join(first, second);
    }
  for (const std::vector<int>& group : groups.all()) {
    double least = 1;
    for (const int body : group) least = std::min(least, shares[body]);
    for (const int body : group) shares[body] = least;
  }
}

}  // namespace

void approach(const StepProblem& problem, Iterate& iterate) {
  const ContactGeometry& geometry = *problem.contact.geometry;
  const Points way = iterate.positions - problem.positions_t0;
  double farthest = 1;
  bool has_fast_parts = false;
  for (const FastPair& pair :
       fast_pairs(*problem.model, geometry.touchable, geometry.hex_starts, problem.positions_t0, iterate.positions)) {
    farthest = std::max(farthest, pair.approach);
    has_fast_parts = has_fast_parts || pair.body == pair.other;
  }
  const int parts = int(std::ceil(farthest));
  if (parts == 1) return;
  for (int part = 1; part <= parts; ++part) {
    iterate.positions = problem.positions_t0 + double(part) / parts * way;
    if (bodies_meet(problem.contact, iterate.apart, iterate.positions, problem.joining_share, has_fast_parts)) break;
    iterate.apart = LastApart(iterate.positions);
  }
  place_driven(problem.pins, iterate.positions);
  update_contacts(problem.contact, iterate.apart, iterate.positions, iterate.contacts);
}

double felt_share(const StepProblem& problem, const Iterate& iterate, const VectorXd& step) {
  return 1 / approaches(problem, iterate.positions, iterate.positions + unflatten(step)).maxCoeff();
}

VectorXd as_far_as_felt(const StepProblem& problem, const Iterate& iterate, const VectorXd& step, VectorXd shares) {
  if (shares.maxCoeff() <= 1) return shares;
  VectorXd scaled = step;
  scale_bodies(*problem.model, shares, scaled);
  const double felt = felt_share(problem, iterate, scaled);
  return (shares.array() > 1).select(felt * shares, shares);
}

VectorXd body_shares(const StepProblem& problem, const Iterate& iterate, const VectorXd& step) {
  const Model& model = *problem.model;
  VectorXd shares = step_fractions(model, step);
  if (!problem.contact.geometry->touchable.any()) return VectorXd::Constant(shares.size(), shares.minCoeff());
  shares = shares.cwiseMin(approaches(problem, iterate.positions, iterate.positions + unflatten(step)).cwiseInverse());
  const double least = shares.minCoeff();
  share_alike(problem, iterate, shares);
  VectorXd scaled = step;
  scale_bodies(model, shares, scaled);
  const bool passes = felt_share(problem, iterate, scaled) < 1;  // a slow one may leave others behind, or fall behind
  return passes ? VectorXd::Constant(shares.size(), least) : shares;
}

void scale_bodies(const Model& model, const VectorXd& shares, VectorXd& step) {
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    step.segment(3 * model.bodies[b].first_node, 3 * model.bodies[b].num_nodes) *= shares[Eigen::Index(b)];
}

}  // namespace umax
