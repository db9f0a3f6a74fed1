#include "core/contact/fast_parts.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/element/rotation.h"

namespace umax {
namespace {

constexpr Eigen::Index hexes_per_block = 64;

double farthest(const Points& moves) {
  return std::sqrt(moves.rowwise().squaredNorm().maxCoeff());
}

// The body's nodes at `to`, moved and turned back as a whole; none if they move too little to matter.
Points turned_back(const Model& model, const Model::BodyRange& body, const Points& from, const Points& to) {
  const double little = 0.5 * felt_motion * body.cell_size;  // of two parts, each
  const auto mass = model.node_mass.segment(body.first_node, body.num_nodes);
  const auto before = from.middleRows(body.first_node, body.num_nodes),
             after = to.middleRows(body.first_node, body.num_nodes);
  if (farthest(after - before) <= little) return {};
  const Eigen::RowVector3d centre0 = mass.transpose() * before / mass.sum(),
                           centre1 = mass.transpose() * after / mass.sum();
  const Points arms0 = before.rowwise() - centre0, arms1 = after.rowwise() - centre1;
  if (farthest(arms1 - arms0) <= little) return {};
  Matrix3d rotation = polar_rotation(arms1.transpose() * mass.asDiagonal() * arms0);
  if (rotation.trace() < 1) rotation.setIdentity();  // more than 90 degrees: parts may have changed places instead
  const Points back = arms1 * rotation;              // by its transpose
  if (farthest(back - arms0) <= little) return {};
  return back.rowwise() + centre0;
}

// The ways and motions of a body's hexes, and bounds of them for the nodes of its tree.
struct Ways {
  std::vector<Eigen::AlignedBox3d> boxes, motions;  // per node of the tree: [m] of hexes and of their centres' motions
  Points of_hexes;                                  // #E of the body x 3 [m] motions of their centres
};
Ways find_ways(const Model& model, const Model::BodyRange& body, const HexTree& tree, const Points& from,
               const Points& to) {
  Ways ways{boxes_at(tree, model, from), std::vector<Eigen::AlignedBox3d>(tree.nodes.size()),
            Points(body.num_hexes, 3)};
  const std::vector<Eigen::AlignedBox3d> ends = boxes_at(tree, model, to);
  for (std::size_t i = tree.nodes.size(); i-- > 0;) {  // children are behind their parents
    ways.boxes[i].extend(ends[i]);
    const HexTree::Node& node = tree.nodes[i];
    if (node.hex < 0) {
      ways.motions[i] = ways.motions[std::size_t(node.first)].merged(ways.motions[std::size_t(node.first) + 1]);
      continue;
    }
    const Vector3d motion =
        (hex_nodes(model, to, node.hex) - hex_nodes(model, from, node.hex)).colwise().mean().transpose();
    ways.of_hexes.row(node.hex - body.first_hex) = motion.transpose();
    ways.motions[i] = Eigen::AlignedBox3d(motion);
  }
  return ways;
}

// the largest distance of a point from one in the box
double farthest_in(const Eigen::AlignedBox3d& box, const Vector3d& point) {
  return (point - box.min()).cwiseAbs().cwiseMax((point - box.max()).cwiseAbs()).norm();
}

// the fastest motion of a hex against one that its way meets, in felt_motion; at least 1
double approach_of(const Model& model, const HexTree& tree, const Ways& ways, int hex, const Eigen::AlignedBox3d& way,
                   const Model::BodyRange& body) {
  const double felt = felt_motion * body.cell_size;
  const Vector3d motion = ways.of_hexes.row(hex - body.first_hex).transpose();
  double approach = 1;
  std::vector<int> stack{0};
  while (!stack.empty()) {
    const auto at = std::size_t(stack.back());
    stack.pop_back();
    if (farthest_in(ways.motions[at], motion) <= approach * felt || !ways.boxes[at].intersects(way)) continue;
    const HexTree::Node& node = tree.nodes[at];
    if (node.hex < 0)
      stack.insert(stack.end(), {node.first, node.first + 1});
    else if (!share_node(model, hex, node.hex))
      approach = farthest_in(ways.motions[at], motion) / felt;
  }
  return approach;
}

}  // namespace

std::vector<FastPair> fast_parts(const Model& model, const TouchableBodies& touchable,
                                 const std::vector<int>& hex_starts, const Points& from, const Points& to) {
  std::vector<FastPair> fast;
  Points back;  // of all nodes; those of one body at a time are set
  for (int b = 0; b < int(model.bodies.size()); ++b) {
    const std::vector<int>& surfaces = touchable.surfaces[b];
    if (std::find(surfaces.begin(), surfaces.end(), b) == surfaces.end()) continue;
    const Model::BodyRange& body = model.bodies[b];
    const Points of_body = turned_back(model, body, from, to);
    if (of_body.rows() == 0) continue;
    if (back.rows() == 0) back = to;
    back.middleRows(body.first_node, body.num_nodes) = of_body;
    const HexTree& tree = touchable.trees[b];
    const Ways ways = find_ways(model, body, tree, from, back);
    VectorXd largest = VectorXd::Ones((body.num_hexes + hexes_per_block - 1) / hexes_per_block);
    parallel_blocks(body.num_hexes, hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
      for (int hex = body.first_hex + int(begin); hex < body.first_hex + int(end); ++hex) {
        if (hex_starts[hex] == hex_starts[hex + 1]) continue;
        Eigen::AlignedBox3d way;
        for (int n = 0; n < 8; ++n)
          for (const Points* positions : {&from, static_cast<const Points*>(&back)})
            way.extend(positions->row(model.hexes(hex, n)).transpose());
        double& most = largest[begin / hexes_per_block];
        most = std::max(most, approach_of(model, tree, ways, hex, way, body));
      }
    });
    if (largest.maxCoeff() > 1) fast.push_back({b, b, largest.maxCoeff()});
  }
  return fast;
}

}  // namespace umax
