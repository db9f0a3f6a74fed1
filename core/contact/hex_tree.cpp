#include "core/contact/hex_tree.h"

#include <algorithm>
#include <numeric>

namespace umax {
namespace {

void split(const Points& centres, int first_hex, int at, std::vector<int>::iterator begin,
           std::vector<int>::iterator end, HexTree& tree) {
  if (end - begin == 1) {
    tree.nodes[at].hex = first_hex + *begin;
    return;
  }
  Eigen::AlignedBox3d box;
  for (auto hex = begin; hex != end; ++hex) box.extend(centres.row(*hex).transpose());
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    return centres(a, axis) != centres(b, axis) ? centres(a, axis) < centres(b, axis) : a < b;
  });
  const int first = int(tree.nodes.size());
  tree.nodes[at].first = first;
  tree.nodes.resize(tree.nodes.size() + 2);
  split(centres, first_hex, first, begin, middle, tree);
  split(centres, first_hex, first + 1, middle, end, tree);
}

}  // namespace

HexTree make_hex_tree(const Model& model, int body) {
  const Model::BodyRange& range = model.bodies[body];
  HexTree tree;
  if (range.num_hexes == 0) return tree;
  Points centres(range.num_hexes, 3);
  for (int e = 0; e < range.num_hexes; ++e)
    centres.row(e) = hex_nodes(model, model.rest_positions, range.first_hex + e).colwise().mean();
  std::vector<int> hexes(range.num_hexes);
  std::iota(hexes.begin(), hexes.end(), 0);
  tree.nodes.reserve(2 * hexes.size());
  tree.nodes.resize(1);
  split(centres, range.first_hex, 0, hexes.begin(), hexes.end(), tree);
  return tree;
}

std::vector<Eigen::AlignedBox3d> boxes_at(const HexTree& tree, const Model& model, const Points& positions) {
  std::vector<Eigen::AlignedBox3d> boxes(tree.nodes.size());
  for (std::size_t i = tree.nodes.size(); i-- > 0;) {
    const HexTree::Node& node = tree.nodes[i];
    if (node.hex >= 0)
      for (int n = 0; n < 8; ++n) boxes[i].extend(positions.row(model.hexes(node.hex, n)).transpose());
    else
      boxes[i] = boxes[node.first].merged(boxes[node.first + 1]);
  }
  return boxes;
}

}  // namespace umax
