#include "tests/support/surface_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace umax::test {
namespace {

constexpr int leaf_size = 8;
constexpr double far_field = 2.5;  // [-] times a node's radius

// halves the triangles order[begin, end) by their centres along the longest side of these
struct TreeBuilder {
  const Points& centres;
  std::vector<int> order;
  std::vector<SurfaceTree::Node> nodes;

  void build(int begin, int end) {
    const std::size_t node = nodes.size();
    nodes.push_back({begin, end});
    if (end - begin <= leaf_size) return;
    Box box;
    for (int i = begin; i < end; ++i) box.extend(centres.row(order[i]).transpose());
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                     [&](int a, int b) { return std::pair(centres(a, axis), a) < std::pair(centres(b, axis), b); });
    build(begin, middle);
    nodes[node].right = int(nodes.size());
    build(middle, end);
  }
};

Triangle triangle_at(const SurfaceTree& tree, const Points& positions, int t) {
  const auto corner = [&](int i) -> Vector3d { return positions.row(tree.triangles(t, i)).transpose(); };
  return {corner(0), corner(1), corner(2)};
}

Box box_of(const Triangle& triangle) {
  Box box(triangle.a);
  box.extend(triangle.b);
  box.extend(triangle.c);
  return box;
}

// adds a part to a node, whose centre is the sum of its parts' centres by area until it is complete
void add(const TreeShape::Node& part, TreeShape::Node& node) {
  node.box.extend(part.box);
  node.area += part.area;
  node.total_area += part.total_area;
  node.centre += part.total_area * part.centre;
}

TreeShape::Node node_of(const Triangle& triangle) {
  const Vector3d area = 0.5 * (triangle.b - triangle.a).cross(triangle.c - triangle.a);
  return {.box = box_of(triangle),
          .area = area,
          .centre = (triangle.a + triangle.b + triangle.c) / 3,
          .total_area = area.norm()};
}

// visits the triangles of the nodes that `enter` lets in, all but those that are left out
template <class Enter, class Visit>
void walk(const SurfaceView& surface, const Enter& enter, const Visit& visit) {
  int waiting[64], count = 0;  // the tree is balanced: 2^31 triangles need 32
  waiting[count++] = 0;
  while (count > 0) {
    const int i = waiting[--count];
    const SurfaceTree::Node& node = surface.tree.nodes[i];
    if (surface.left_out && surface.left_out->nodes[i] == node.end - node.begin) continue;
    if (!enter(i)) continue;
    if (!node.is_leaf()) {
      waiting[count++] = node.right;
      waiting[count++] = i + 1;
      continue;
    }
    for (int t = node.begin; t < node.end; ++t)
      if (!surface.left_out || !surface.left_out->triangles[t]) visit(t);
  }
}

// lowers `nearest` [m^2] to the squared distance of the node's triangles
void approach(const SurfaceView& surface, int i, const Vector3d& x, double& nearest) {
  const auto& shapes = surface.shape.nodes;
  const SurfaceTree::Node& node = surface.tree.nodes[i];
  if (surface.left_out && surface.left_out->nodes[i] == node.end - node.begin) return;
  if (shapes[i].box.squaredExteriorDistance(x) >= nearest) return;
  if (node.is_leaf()) {
    for (int t = node.begin; t < node.end; ++t)
      if (!surface.left_out || !surface.left_out->triangles[t])
        nearest = std::min(nearest, squared_distance(triangle_at(surface, t), x));
    return;
  }
  const bool right_first =
      shapes[node.right].box.squaredExteriorDistance(x) < shapes[i + 1].box.squaredExteriorDistance(x);
  approach(surface, right_first ? node.right : i + 1, x, nearest);
  approach(surface, right_first ? i + 1 : node.right, x, nearest);
}

}  // namespace

SurfaceTree build_tree(const Triangles& triangles, const Points& positions) {
  Points centres(triangles.rows(), 3);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    centres.row(t) =
        (positions.row(triangles(t, 0)) + positions.row(triangles(t, 1)) + positions.row(triangles(t, 2))) / 3;
  TreeBuilder builder{centres, std::vector<int>(std::size_t(triangles.rows())), {}};
  std::iota(builder.order.begin(), builder.order.end(), 0);
  builder.build(0, int(triangles.rows()));
  return {std::move(builder.nodes), triangles(builder.order, Eigen::all)};
}

TreeShape shape_tree(const SurfaceTree& tree, Points positions) {
  TreeShape shape{std::move(positions), std::vector<TreeShape::Node>(tree.nodes.size())};
  for (int i = int(tree.nodes.size()) - 1; i >= 0; --i) {
    const SurfaceTree::Node& node = tree.nodes[i];
    TreeShape::Node& out = shape.nodes[i];
    if (node.is_leaf()) {
      for (int t = node.begin; t < node.end; ++t) add(node_of(triangle_at(tree, shape.positions, t)), out);
    } else {
      add(shape.nodes[i + 1], out);
      add(shape.nodes[node.right], out);
    }
    if (out.box.isEmpty()) continue;
    out.centre = out.total_area > 0 ? Vector3d(out.centre / out.total_area) : out.box.center();
    out.radius = (out.centre - out.box.min()).cwiseMax(out.box.max() - out.centre).norm();
  }
  return shape;
}

LeftOut leave_out(const SurfaceTree& tree, const std::vector<int>& triangles) {
  LeftOut out{std::vector<char>(std::size_t(tree.triangles.rows())), std::vector<int>(tree.nodes.size())};
  for (const int t : triangles) out.triangles[t] = 1;
  for (int i = int(tree.nodes.size()) - 1; i >= 0; --i) {
    const SurfaceTree::Node& node = tree.nodes[i];
    out.nodes[i] = node.is_leaf()
                       ? std::accumulate(out.triangles.data() + node.begin, out.triangles.data() + node.end, 0)
                       : out.nodes[i + 1] + out.nodes[node.right];
  }
  return out;
}

Triangle triangle_at(const SurfaceView& surface, int triangle) {
  return triangle_at(surface.tree, surface.shape.positions, triangle);
}

double winding_number(const SurfaceView& surface, const Vector3d& x) {
  double sum = 0;  // [sr]
  const auto add_far = [&](int i) {
    const TreeShape::Node& node = surface.shape.nodes[i];
    const Vector3d away = node.centre - x;
    const double squared = away.squaredNorm(), reach = far_field * node.radius;
    const bool is_far = squared > reach * reach && (!surface.left_out || surface.left_out->nodes[i] == 0);
    if (is_far) sum += node.area.dot(away) / (squared * std::sqrt(squared));
    return !is_far;
  };
  walk(surface, add_far, [&](int t) { sum += solid_angle(triangle_at(surface, t), x); });
  return sum / (4 * std::numbers::pi);
}

double distance(const SurfaceView& surface, const Vector3d& x) {
  double nearest = std::numeric_limits<double>::infinity();
  approach(surface, 0, x, nearest);
  return std::sqrt(nearest);
}

std::vector<int> triangles_in(const SurfaceView& surface, const Box& box) {
  std::vector<int> found;
  walk(
      surface, [&](int i) { return surface.shape.nodes[i].box.intersects(box); },
      [&](int t) {
        if (box_of(triangle_at(surface, t)).intersects(box)) found.push_back(t);
      });
  return found;
}

bool has_triangles_in(const SurfaceView& surface, const Box& box) {
  bool found = false;
  walk(
      surface, [&](int i) { return !found && surface.shape.nodes[i].box.intersects(box); },
      [&](int t) { found = found || box_of(triangle_at(surface, t)).intersects(box); });
  return found;
}

}  // namespace umax::test
