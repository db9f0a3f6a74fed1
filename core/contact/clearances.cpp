#include "core/contact/clearances.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index encounters_per_block = 16, hexes_per_block = 256;

// a sphere around the motions of a hex's nodes [m]
struct Motions {
  Vector3d centre{0, 0, 0};
  double radius = 0;
};
std::vector<Motions> motions_of_hexes(const Model& model, const Points& from, const Points& to) {
  const Points moves = to - from;
  std::vector<Motions> motions(std::size_t(model.num_hexes()));
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      const Matrix8x3d of_nodes = hex_nodes(model, moves, e);
      const Eigen::RowVector3d centre = of_nodes.colwise().mean();
      motions[std::size_t(e)] = {centre.transpose(),
                                 std::sqrt((of_nodes.rowwise() - centre).rowwise().squaredNorm().maxCoeff())};
    }
  });
  return motions;
}

// the longest way of the hex against one of the others, where it is longer seen from their material there
double way_against(const Encounter& encounter, const std::vector<Motions>& motions,
                   const std::vector<HexBounds>& bounds) {
  const Motions& own = motions[std::size_t(encounter.hex)];
  double longest = 0;
  for (const int other : encounter.others) {
    const Motions& its = motions[std::size_t(other)];
    const double moved = (own.centre - its.centre).norm() + own.radius + its.radius;
    if (moved > 0) longest = std::max(longest, moved * std::max(1.0, bounds[std::size_t(other)].largest_inverse));
  }
  return longest;
}

// what is known of an encounter that has been found anew, with other hexes of the body
Clearances::OfEncounter carried_over(const Encounter& before, const Encounter& now, Clearances::OfEncounter known) {
  if (known.until.empty()) return {};
  std::vector<int> seen, unseen;
  std::set_difference(before.others.begin(), before.others.end(), known.unseen.begin(), known.unseen.end(),
                      std::back_inserter(seen));
  std::set_difference(now.others.begin(), now.others.end(), seen.begin(), seen.end(), std::back_inserter(unseen));
  known.unseen = std::move(unseen);
  return known;
}

}  // namespace

void complete(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
              const Points& positions, double margin, Clearances& clearances) {
  Encounters& encounters = clearances.encounters;
  if (encounters.expected.rows() == 0) encounters = find_encounters(model, touchable, hex_starts, positions, margin);
  clearances.of_encounters.resize(encounters.all.size());
  const std::vector<char> left = left_margin(model, encounters, positions, margin);
  if (std::find(left.begin(), left.end(), 1) == left.end()) return;
  for (std::size_t b = 0; b < left.size(); ++b) {
    const Model::BodyRange& body = model.bodies[b];
    if (left[b])
      encounters.expected.middleRows(body.first_node, body.num_nodes) =
          positions.middleRows(body.first_node, body.num_nodes);
  }
  Encounters renewed =
      find_encounters_of(model, touchable, hex_starts, encounters.expected, margin,
                         [&](int body, int other) { return left[std::size_t(body)] || left[std::size_t(other)]; });
  std::vector<Clearances::OfEncounter> kept;
  std::vector<Encounter> all;
  auto next = renewed.all.begin();
  const auto place = [](const Encounter& encounter) { return std::pair(encounter.hex, encounter.body); };
  const auto take_renewed = [&] {
    all.push_back(std::move(*next++));
    kept.emplace_back();
  };
  for (std::size_t i = 0; i < encounters.all.size(); ++i) {
    Encounter& encounter = encounters.all[i];
    while (next != renewed.all.end() && place(*next) < place(encounter)) take_renewed();
    if (!left[std::size_t(model.hex_body[encounter.hex])] && !left[std::size_t(encounter.body)]) {
      all.push_back(std::move(encounter));
      kept.push_back(std::move(clearances.of_encounters[i]));
    } else if (next != renewed.all.end() && place(*next) == place(encounter)) {
      take_renewed();
      kept.back() = carried_over(encounter, all.back(), std::move(clearances.of_encounters[i]));
    }
  }
  while (next != renewed.all.end()) take_renewed();
  encounters.all = std::move(all);
  clearances.of_encounters = std::move(kept);
}

void advance(const Model& model, const std::vector<HexBounds>& bounds, const Points& positions,
             Clearances& clearances) {
  if (clearances.positions.size() > 0) {
    const std::vector<Motions> motions = motions_of_hexes(model, clearances.positions, positions);
    parallel_blocks(Eigen::Index(clearances.of_encounters.size()), encounters_per_block,
                    [&](Eigen::Index begin, Eigen::Index end) {
                      for (Eigen::Index i = begin; i < end; ++i) {
                        Clearances::OfEncounter& of = clearances.of_encounters[std::size_t(i)];
                        if (of.until.empty()) continue;
                        of.way += way_against(clearances.encounters.all[std::size_t(i)], motions, bounds);
                        if (!std::isfinite(of.way)) of = {};  // through a hex turned inside out: looked at anew
                      }
                    });
  }
  clearances.positions = positions;
}

}  // namespace umax
