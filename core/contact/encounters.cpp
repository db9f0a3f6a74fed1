#include "core/contact/encounters.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "core/base/parallel.h"
#include "core/contact/fast_parts.h"
#include "core/element/rotation.h"

namespace umax {
namespace {

constexpr Eigen::Index hexes_per_block = 64;

// [cells] from the rest shape, of nodes in hexes that cannot meet yet: with the largest margin less than half a cell
constexpr double nearly_rigid = 0.3, largest_margin = 0.15;

using Boxes = std::vector<Eigen::AlignedBox3d>;

Eigen::AlignedBox3d box_of(const Model& model, const Points& positions, int hex) {
  Eigen::AlignedBox3d box;
  for (int n = 0; n < 8; ++n) box.extend(positions.row(model.hexes(hex, n)).transpose());
  return box;
}

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box, double by) {
  return {box.min() - Vector3d::Constant(by), box.max() + Vector3d::Constant(by)};
}

// per body: the bodies that its vertices may touch
using Surfaces = std::vector<std::vector<int>>;

// boxes of the bodies that are among the surfaces
std::vector<Boxes> boxes_of_bodies(const Model& model, const TouchableBodies& touchable, const Surfaces& surfaces,
                                   const Points& positions) {
  std::vector<Boxes> boxes(model.bodies.size());
  for (const std::vector<int>& bodies : surfaces)
    for (const int body : bodies)
      if (boxes[body].empty()) boxes[body] = boxes_at(touchable.trees[body], model, positions);
  return boxes;
}

// Are all nodes of a body with a regular cage so near their places in the rest shape, moved and turned as a whole, that
// hexes without a common node, at rest one cell apart, cannot meet?
bool is_nearly_rigid(const Model& model, const Model::BodyRange& body, const Points& positions) {
  if (body.cells.rows() == 0) return false;
  const auto mass = model.node_mass.segment(body.first_node, body.num_nodes);
  const auto rest = model.rest_positions.middleRows(body.first_node, body.num_nodes);
  const auto now = positions.middleRows(body.first_node, body.num_nodes);
  const Eigen::RowVector3d rest_centre = mass.transpose() * rest / mass.sum(),
                           centre = mass.transpose() * now / mass.sum();
  const Points rest_arms = rest.rowwise() - rest_centre, arms = now.rowwise() - centre;
  const Matrix3d rotation = polar_rotation(arms.transpose() * mass.asDiagonal() * rest_arms);
  const double farthest = (arms - rest_arms * rotation.transpose()).rowwise().squaredNorm().maxCoeff();
  return farthest <= std::pow(nearly_rigid * body.cell_size, 2);
}

// of the wanted surfaces that vertices may touch, those whose bodies come near theirs; by: [m] that boxes are grown
Surfaces near_surfaces(const Model& model, const TouchableBodies& touchable, const Points& positions, double by,
                       const WantedBodies& wanted) {
  std::vector<Eigen::AlignedBox3d> boxes(model.bodies.size());
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    const auto nodes = positions.middleRows(model.bodies[b].first_node, model.bodies[b].num_nodes);
    boxes[b] = {nodes.colwise().minCoeff().transpose(), nodes.colwise().maxCoeff().transpose()};
  }
  Surfaces near(model.bodies.size());
  for (std::size_t b = 0; b < near.size(); ++b)
    for (const int other : touchable.surfaces[b])
      if (!wanted(int(b), other))
        continue;
      else if (int(b) == other ? !is_nearly_rigid(model, model.bodies[b], positions)
                               : grown(boxes[b], by).intersects(boxes[other]))
        near[b].push_back(other);
  return near;
}

// Calls visit(block, hex, body, others) for each hex with vertices and each body that these may touch, in parallel.
// box(hex): of the hex.
template <class Box, class Visit>
void visit_meetings(const Model& model, const TouchableBodies& touchable, const Surfaces& surfaces,
                    const std::vector<int>& hex_starts, const std::vector<Boxes>& boxes, const Box& box,
                    const Visit& visit) {
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (int hex = int(begin); hex < int(end); ++hex) {
      if (hex_starts[hex] == hex_starts[hex + 1] || surfaces[model.hex_body[hex]].empty()) continue;
      const Eigen::AlignedBox3d around = box(hex);
      for (const int body : surfaces[model.hex_body[hex]]) {
        std::vector<int> others;
        for_each_hex_in(touchable.trees[body], boxes[body], around, [&](int other) {
          if (body != model.hex_body[hex] || !share_node(model, hex, other)) others.push_back(other);
        });
        if (others.empty()) continue;
        std::sort(others.begin(), others.end());
        visit(begin / hexes_per_block, hex, body, std::move(others));
      }
    }
  });
}

// Leaves of encounters of boxes those of which a closer look says that the hexes may meet; by: [m] as in may_meet().
void keep_meeting(const Model& model, const Points& positions, double by, std::vector<Encounter>& encounters) {
  const std::vector<HexBounds> bounds = bound_hexes(model, encounters, positions);
  parallel_blocks(Eigen::Index(encounters.size()), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      Encounter& encounter = encounters[std::size_t(i)];
      const Matrix8x3d nodes = hex_nodes(model, positions, encounter.hex);
      std::erase_if(encounter.others, [&](int other) { return !may_meet(bounds[std::size_t(other)], nodes, by); });
    }
  });
  std::erase_if(encounters, [](const Encounter& encounter) { return encounter.others.empty(); });
}

std::size_t num_blocks(const Model& model) {
  return std::size_t((model.num_hexes() + hexes_per_block - 1) / hexes_per_block);
}

// How the nodes of a body move on straight ways.
struct BodyMotion {
  Vector3d mean{0, 0, 0};             // [m]
  double spread = 0;                  // [m] of the motion that differs most from the mean
  Eigen::AlignedBox3d before, after;  // of the nodes
};
std::vector<BodyMotion> body_motions(const Model& model, const Points& from, const Points& to) {
  std::vector<BodyMotion> motions(model.bodies.size());
  for (std::size_t b = 0; b < motions.size(); ++b) {
    const auto before = from.middleRows(model.bodies[b].first_node, model.bodies[b].num_nodes),
               after = to.middleRows(model.bodies[b].first_node, model.bodies[b].num_nodes);
    const Points moves = after - before;
    const Eigen::RowVector3d mean = moves.colwise().mean();
    motions[b].mean = mean.transpose();
    motions[b].spread = std::sqrt((moves.rowwise() - mean).rowwise().squaredNorm().maxCoeff());
    motions[b].before = {before.colwise().minCoeff().transpose(), before.colwise().maxCoeff().transpose()};
    motions[b].after = {after.colwise().minCoeff().transpose(), after.colwise().maxCoeff().transpose()};
  }
  return motions;
}

// [m] that two hexes of the bodies may move against each other between two looks
double felt_between(const Model& model, int body, int other) {
  return felt_motion * std::min(model.bodies[body].cell_size, model.bodies[other].cell_size);
}

// Other bodies, of those that vertices may touch, that move far against theirs and may meet them on the way.
Surfaces fast_surfaces(const Model& model, const TouchableBodies& touchable, const std::vector<BodyMotion>& motions) {
  Surfaces fast(model.bodies.size());
  for (int body = 0; body < int(fast.size()); ++body)
    for (const int other : touchable.surfaces[body]) {
      if (body == other) continue;
      const BodyMotion &own = motions[body], &its = motions[other];
      if ((own.mean - its.mean).norm() + own.spread + its.spread <= felt_between(model, body, other)) continue;
      const Eigen::AlignedBox3d way = own.before.merged(own.after.translated(-its.mean));  // seen from the other body
      if (way.intersects(its.before.merged(its.after.translated(-its.mean)))) fast[body].push_back(other);
    }
  return fast;
}

// boxes of the tree's nodes on their ways, seen from something that moves
Boxes boxes_on_way(const HexTree& tree, const Model& model, const Points& from, const Points& to,
                   const Vector3d& observer) {
  Boxes boxes = boxes_at(tree, model, from);
  const Boxes ends = boxes_at(tree, model, to);
  for (std::size_t i = 0; i < boxes.size(); ++i) boxes[i].extend(ends[i].translated(-observer));
  return boxes;
}

// Calls visit(hex, other) for hexes of different bodies that move far against each other and whose boxes meet on the
// way, seen from the touched body; in parallel by hex.
template <class Visit>
void for_each_fast_meeting(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                           const Points& from, const Points& to, const std::vector<BodyMotion>& motions,
                           const Surfaces& fast, const Visit& visit) {
  std::vector<Boxes> boxes(model.bodies.size());
  for (const std::vector<int>& bodies : fast)
    for (const int body : bodies)
      if (boxes[body].empty()) boxes[body] = boxes_on_way(touchable.trees[body], model, from, to, motions[body].mean);
  for (int body = 0; body < int(fast.size()); ++body) {
    if (fast[body].empty()) continue;
    parallel_blocks(model.bodies[body].num_hexes, hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
      for (int hex = model.bodies[body].first_hex + int(begin); hex < model.bodies[body].first_hex + int(end); ++hex) {
        if (hex_starts[hex] == hex_starts[hex + 1]) continue;
        const Eigen::AlignedBox3d before = box_of(model, from, hex), after = box_of(model, to, hex);
        for (const int other : fast[body])
          for_each_hex_in(touchable.trees[other], boxes[other], before.merged(after.translated(-motions[other].mean)),
                          [&](int met) { visit(hex, met); });
      }
    });
  }
}

double largest_cell(const Model& model) {
  double largest = 0;
  for (const Model::BodyRange& body : model.bodies) largest = std::max(largest, body.cell_size);
  return largest;
}

}  // namespace

bool TouchableBodies::any() const {
  return std::any_of(surfaces.begin(), surfaces.end(), [](const std::vector<int>& of) { return !of.empty(); });
}

bool share_node(const Model& model, int a, int b) {
  for (int m = 0; m < 8; ++m)
    for (int n = 0; n < 8; ++n)
      if (model.hexes(a, m) == model.hexes(b, n)) return true;
  return false;
}

TouchableBodies find_touchable(const Model& model) {
  const int count = int(model.bodies.size());
  TouchableBodies touchable{std::vector<std::vector<int>>(count), std::vector<HexTree>(count)};
  for (int other = 0; other < count; ++other) {
    if (!model.bodies[other].rest_surface) continue;
    for (int body = 0; body < count; ++body) {
      if (!may_touch(model, body, other)) continue;
      touchable.surfaces[body].push_back(other);
      if (touchable.trees[other].nodes.empty()) touchable.trees[other] = make_hex_tree(model, other);
    }
  }
  return touchable;
}

std::vector<HexBounds> bound_hexes(const Model& model, const std::vector<Encounter>& encounters,
                                   const Points& positions) {
  std::vector<char> wanted(std::size_t(model.num_hexes()), 0);
  for (const Encounter& encounter : encounters)
    for (const int other : encounter.others) wanted[std::size_t(other)] = 1;
  std::vector<HexBounds> bounds(wanted.size());
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e)
      if (wanted[std::size_t(e)]) bounds[std::size_t(e)] = bound_hex(model, positions, int(e));
  });
  return bounds;
}

Encounters find_encounters(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                           const Points& positions, double margin) {
  return find_encounters_of(model, touchable, hex_starts, positions, margin, [](int, int) { return true; });
}

Encounters find_encounters_of(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                              const Points& positions, double margin, const WantedBodies& wanted) {
  assert(margin <= largest_margin);
  Encounters encounters{positions, {}};
  std::vector<std::vector<Encounter>> of_blocks(num_blocks(model));
  const double of_others = margin * largest_cell(model);  // theirs is in the box of the hex
  const Surfaces near = near_surfaces(model, touchable, positions, 2 * of_others, wanted);
  if (std::all_of(near.begin(), near.end(), [](const std::vector<int>& of) { return of.empty(); })) return encounters;
  visit_meetings(
      model, touchable, near, hex_starts, boxes_of_bodies(model, touchable, near, positions),
      [&](int hex) { return grown(box_of(model, positions, hex), margin * body_of(model, hex).cell_size + of_others); },
      [&](Eigen::Index block, int hex, int body, std::vector<int> others) {
        of_blocks[block].push_back({hex, body, std::move(others)});
      });
  for (std::vector<Encounter>& block : of_blocks)
    std::move(block.begin(), block.end(), std::back_inserter(encounters.all));
  keep_meeting(model, positions, of_others, encounters.all);
  return encounters;
}

std::vector<char> left_margin(const Model& model, const Encounters& encounters, const Points& positions,
                              double margin) {
  std::vector<char> left;
  for (const Model::BodyRange& body : model.bodies) {
    const auto moved = positions.middleRows(body.first_node, body.num_nodes) -
                       encounters.expected.middleRows(body.first_node, body.num_nodes);
    left.push_back(!(moved.rowwise().squaredNorm().maxCoeff() <= std::pow(margin * body.cell_size, 2)));
  }
  return left;
}

std::vector<FastPair> fast_pairs(const Model& model, const TouchableBodies& touchable,
                                 const std::vector<int>& hex_starts, const Points& from, const Points& to) {
  const auto motion = [&](int hex) -> Vector3d {
    return (hex_nodes(model, to, hex) - hex_nodes(model, from, hex)).colwise().mean().transpose();
  };
  const std::vector<BodyMotion> motions = body_motions(model, from, to);
  const Surfaces fast = fast_surfaces(model, touchable, motions);
  std::vector<FastPair> own = fast_parts(model, touchable, hex_starts, from, to);
  if (std::all_of(fast.begin(), fast.end(), [](const std::vector<int>& of) { return of.empty(); })) return own;
  std::vector<std::vector<FastPair>> of_hexes(std::size_t(model.num_hexes()));
  for_each_fast_meeting(model, touchable, hex_starts, from, to, motions, fast, [&](int hex, int other) {
    std::vector<FastPair>& pairs = of_hexes[std::size_t(hex)];
    const int body = model.hex_body[hex], met = model.hex_body[other];
    if (pairs.empty() || pairs.back().other != met) pairs.push_back({body, met});  // they come one after the other
    const double approach = (motion(other) - motion(hex)).norm() / felt_between(model, body, met);
    pairs.back().approach = std::max(pairs.back().approach, approach);
  });
  std::map<std::pair<int, int>, double> largest;
  for (const FastPair& pair : own) largest[{pair.body, pair.other}] = pair.approach;
  for (const std::vector<FastPair>& pairs : of_hexes)
    for (const FastPair& pair : pairs) {
      double& approach = largest[{pair.body, pair.other}];
      approach = std::max(approach, pair.approach);
    }
  std::vector<FastPair> all;
  for (const auto& [bodies, approach] : largest) all.push_back({bodies.first, bodies.second, approach});
  return all;
}

VectorXd largest_approaches(const Model& model, const TouchableBodies& touchable, const std::vector<int>& hex_starts,
                            const Points& from, const Points& to) {
  VectorXd approaches = VectorXd::Ones(Eigen::Index(model.bodies.size()));
  for (const FastPair& pair : fast_pairs(model, touchable, hex_starts, from, to))
    for (const int body : {pair.body, pair.other}) approaches[body] = std::max(approaches[body], pair.approach);
  return approaches;
}

}  // namespace umax
