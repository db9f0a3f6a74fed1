#include "embedding/cage/hex_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <utility>

#include "core/element/hexahedron.h"
#include "embedding/cage/cell_table.h"

namespace umax {
namespace {

constexpr int leaf_size = 4;
constexpr double reach = 1 + 2 * face_tolerance;  // of the coordinates s in [-1, 1]

// Solves sum_n N_n(s) nodes_n = 0 from a start; whether it got there.
bool solve(const Matrix8x3d& nodes, Vector3d& s) {
  constexpr int max_iterations = 40;
  constexpr double far = 4;  // beyond it the map may fold back
  for (int i = 0; i < max_iterations; ++i) {
    const Matrix3d F = nodes.transpose() * shape_gradients(s);
    const Vector3d step = F.partialPivLu().solve(nodes.transpose() * shape_functions(s));
    if (!step.allFinite()) return false;
    s -= step;
    if (step.cwiseAbs().maxCoeff() < 1e-14) return true;
    if (s.cwiseAbs().maxCoeff() > far) return false;
  }
  // rounding keeps the last digits moving
  return (nodes.transpose() * shape_functions(s)).norm() < 1e-12 * nodes.cwiseAbs().maxCoeff();
}

}  // namespace

bool HexSearch::Box::contains(const Vector3d& point) const {
  return (point.array() >= low.array()).all() && (point.array() <= high.array()).all();
}

HexSearch::HexSearch(const Lattice& lattice) : lattice_(lattice) {
  const auto num_hexes = std::size_t(lattice.num_hexes());
  boxes_.resize(num_hexes);
  for (std::size_t e = 0; e < num_hexes; ++e) {
    const Matrix8x3d nodes = rest_nodes(lattice, Eigen::Index(e));
    const Vector3d low = nodes.colwise().minCoeff(), high = nodes.colwise().maxCoeff();
    // the tolerance at a face, and the rounding of coordinates far from the origin
    const double slack = 4 * face_tolerance * (high - low).maxCoeff() + 1e-15 * nodes.cwiseAbs().maxCoeff();
    boxes_[e] = {low - Vector3d::Constant(slack), high + Vector3d::Constant(slack)};
  }
  order_.resize(num_hexes);
  std::iota(order_.begin(), order_.end(), 0);
  if (num_hexes > 0) grow(0, int(num_hexes));
}

int HexSearch::grow(int first, int last) {
  const int index = int(branches_.size());
  branches_.emplace_back();
  Branch branch{.box = boxes_[std::size_t(order_[std::size_t(first)])], .first = first, .last = last};
  for (int i = first; i < last; ++i) {
    const Box& box = boxes_[std::size_t(order_[std::size_t(i)])];
    branch.box.low = branch.box.low.cwiseMin(box.low);
    branch.box.high = branch.box.high.cwiseMax(box.high);
  }
  if (last - first > leaf_size) {
    // halves along the longest axis; equal centres by index, so that the tree depends on nothing else
    int axis = 0;
    (branch.box.high - branch.box.low).maxCoeff(&axis);
    const auto centre = [&](int e) { return boxes_[std::size_t(e)].low[axis] + boxes_[std::size_t(e)].high[axis]; };
    const int middle = (first + last) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                     [&](int a, int b) { return std::pair(centre(a), a) < std::pair(centre(b), b); });
    branch.left = grow(first, middle);
    branch.right = grow(middle, last);
  }
  branches_[std::size_t(index)] = branch;
  return index;
}

bool HexSearch::holds(int hex, const Vector3d& point, Vector3d& local) const {
  const Matrix8x3d nodes = rest_nodes(lattice_, hex).rowwise() - point.transpose();
  for (int n = 0; n < 8; ++n)
    if (nodes.row(n).isZero(0)) {
      local = Vector3d(n >> 2 & 1, n >> 1 & 1, n & 1);
      return true;
    }

  // coordinates of the linear map at the centre: where all nodes lie on one side, the point is outside
  const Matrix3d F = nodes.transpose() * shape_gradients(Vector3d::Zero());
  const Matrix8x3d flat = nodes * F.inverse().transpose();
  if ((flat.colwise().minCoeff().array() > 4 * face_tolerance).any() ||
      (flat.colwise().maxCoeff().array() < -4 * face_tolerance).any())
    return false;

  // from the centre, else from nearer starts: a very distorted hex may send the first one astray
  for (int start = -1; start < 8; ++start) {
    Vector3d s = start < 0 ? Vector3d(0, 0, 0) : quadrature_points()[std::size_t(start)];
    if (!solve(nodes, s)) continue;
    if (s.cwiseAbs().maxCoeff() > reach) continue;
    local = 0.5 * (s + Vector3d::Ones());
    return true;
  }
  return false;
}

int HexSearch::find(const Vector3d& point, Vector3d& local) const {
  if (!point.allFinite() || branches_.empty()) return -1;
  int lowest = -1;
  std::vector<int> open{0};
  while (!open.empty()) {
    const Branch& branch = branches_[std::size_t(open.back())];
    open.pop_back();
    if (!branch.box.contains(point)) continue;
    if (branch.left >= 0) {
      open.push_back(branch.left);
      open.push_back(branch.right);
      continue;
    }
    for (int i = branch.first; i < branch.last; ++i) {
      const int hex = order_[std::size_t(i)];
      Vector3d there;
      if ((lowest >= 0 && hex > lowest) || !boxes_[std::size_t(hex)].contains(point) || !holds(hex, point, there))
        continue;
      lowest = hex;
      local = there;
    }
  }
  return lowest;
}

}  // namespace umax
