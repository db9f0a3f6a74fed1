// A bounding volume hierarchy over the hexes of a body: its shape is that of the rest state, its boxes follow the nodes.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/model/model.h"

namespace umax {

struct HexTree {
  struct Node {
    int hex = -1;   // of a leaf, as the model counts; -1: inner
    int first = 0;  // of an inner node: its children are first and first + 1, both behind it
  };
  std::vector<Node> nodes;  // the first is the root
};

/// Of one body: halved at the median along the longest axis of its hexes' centres.
HexTree make_hex_tree(const Model& model, int body);

/// The boxes of the tree's nodes at the positions.
std::vector<Eigen::AlignedBox3d> boxes_at(const HexTree& tree, const Model& model, const Points& positions);

/// Calls visit(hex) for each hex whose box meets the given one, in no useful order.
template <class Visit>
void for_each_hex_in(const HexTree& tree, const std::vector<Eigen::AlignedBox3d>& boxes, const Eigen::AlignedBox3d& box,
                     const Visit& visit) {
  if (tree.nodes.empty()) return;
  int stack[64], size = 0;  // deep enough for 2^63 hexes: the halves are equal
  stack[size++] = 0;
  while (size > 0) {
    const int at = stack[--size];
    if (!boxes[at].intersects(box)) continue;
    const HexTree::Node& node = tree.nodes[at];
    if (node.hex >= 0) {
      visit(node.hex);
    } else {
      stack[size++] = node.first;
      stack[size++] = node.first + 1;
    }
  }
}

}  // namespace umax
