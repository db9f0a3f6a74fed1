#include "tests/support/hex_hulls.h"

#include <algorithm>
#include <numeric>

namespace umax::test {
namespace {

// sum of the four edges along an axis; node n lies at bit 2, 1, 0 of n along axis 0, 1, 2
Vector3d edges_along(const Matrix8x3d& nodes, int axis) {
  Vector3d sum = Vector3d::Zero();
  for (int n = 0; n < 8; ++n) sum += (n >> (2 - axis) & 1 ? 1 : -1) * nodes.row(n).transpose();
  return sum;
}

HexHull hull_of(const Matrix8x3d& nodes) {
  HexHull hull;
  hull.nodes = nodes;
  for (int n = 0; n < 8; ++n) hull.box.extend(nodes.row(n).transpose());
  for (int axis = 0; axis < 3; ++axis) {
    hull.normals[axis] = edges_along(nodes, (axis + 1) % 3).cross(edges_along(nodes, (axis + 2) % 3)).normalized();
    const Vector8d along = nodes * hull.normals[axis];
    hull.low[axis] = along.minCoeff();
    hull.high[axis] = along.maxCoeff();
  }
  return hull;
}

// whether one of a's planes lies between the two, with the margin
bool is_apart(const HexHull& a, const HexHull& b, double margin) {
  for (int axis = 0; axis < 3; ++axis) {
    const Vector8d along = b.nodes * a.normals[axis];
    if (along.minCoeff() > a.high[axis] + margin || along.maxCoeff() < a.low[axis] - margin) return true;
  }
  return false;
}

bool share_a_node(const Model& model, int a, int b) {
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      if (model.hexes(a, i) == model.hexes(b, j)) return true;
  return false;
}

}  // namespace

std::vector<HexHull> hex_hulls(const Model& model, int body, const Points& node_positions) {
  const Model::BodyRange& range = model.bodies[body];
  std::vector<HexHull> hulls;
  for (int i = 0; i < range.num_hexes; ++i)
    hulls.push_back(hull_of(hex_nodes(model, node_positions, range.first_hex + i)));
  return hulls;
}

bool may_hold(const HexHull& hull, const Vector3d& x, double margin) {
  for (int axis = 0; axis < 3; ++axis) {
    const double along = hull.normals[axis].dot(x);
    if (along < hull.low[axis] - margin || along > hull.high[axis] + margin) return false;
  }
  return true;
}

std::vector<std::vector<int>> close_hexes(const Model& model, int body, const std::vector<HexHull>& hulls,
                                          double margin) {
  // sweep along x: only hexes whose boxes are met at the same x are compared
  std::vector<int> order(hulls.size());
  std::iota(order.begin(), order.end(), 0);
  const auto low = [&](int i) { return hulls[i].box.min()[0]; };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return std::pair(low(a), a) < std::pair(low(b), b); });
  std::vector<std::vector<int>> close(hulls.size());
  const Vector3d reach = Vector3d::Constant(margin);
  const int first = model.bodies[body].first_hex;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int a = order[i];
    const Box box(hulls[a].box.min() - reach, hulls[a].box.max() + reach);
    for (std::size_t j = i + 1; j < order.size() && low(order[j]) <= box.max()[0]; ++j) {
      const int b = order[j];
      if (!box.intersects(hulls[b].box) || share_a_node(model, first + a, first + b) ||
          is_apart(hulls[a], hulls[b], margin) || is_apart(hulls[b], hulls[a], margin))
        continue;
      close[a].push_back(b);
      close[b].push_back(a);
    }
  }
  return close;
}

std::vector<int> hexes_around(const Model& model, const std::vector<int>& hexes) {
  std::vector<int> around;
  for (const int hex : hexes)
    for (int n = 0; n < 8; ++n) {
      const int node = model.hexes(hex, n);
      for (int c = model.corner_starts[node]; c < model.corner_starts[node + 1]; ++c)
        around.push_back(model.corners[c] / 8);
    }
  std::sort(around.begin(), around.end());
  around.erase(std::unique(around.begin(), around.end()), around.end());
  return around;
}

}  // namespace umax::test
