#include "embedding/surface/topology.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <tuple>

namespace umax {
namespace {

using Bits = std::array<std::uint64_t, 3>;

Bits position_bits(const Points& positions, Eigen::Index v) {
  Bits bits;
  for (int axis = 0; axis < 3; ++axis)
    bits[axis] = std::bit_cast<std::uint64_t>(positions(v, axis) + 0.0);  // -0 becomes 0
  return bits;
}

std::uint64_t hash(const Bits& bits) {
  std::uint64_t h = 0x9e3779b97f4a7c15ull;
  for (std::uint64_t b : bits) {
    h = (h ^ b) * 0xff51afd7ed558ccdull;
    h ^= h >> 32;
  }
  return h;
}

double triangle_area(const Points& positions, const Eigen::RowVector3i& t) {
  const Vector3d a = positions.row(t[0]), b = positions.row(t[1]), c = positions.row(t[2]);
  return 0.5 * (b - a).cross(c - a).norm();
}

}  // namespace

std::vector<int> weld(const Points& positions) {
  // open addressing; vertices come in order, so the first one at a position keeps the slot
  const std::size_t num_slots = std::bit_ceil(std::size_t(positions.rows()) * 2 + 1);
  std::vector<int> slots(num_slots, -1), welded(positions.rows());
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    const Bits bits = position_bits(positions, v);
    std::size_t slot = hash(bits) & (num_slots - 1);
    while (slots[slot] >= 0 && position_bits(positions, slots[slot]) != bits) slot = (slot + 1) & (num_slots - 1);
    if (slots[slot] < 0) slots[slot] = int(v);
    welded[v] = slots[slot];
  }
  return welded;
}

std::vector<EdgeUse> edge_uses(const Triangles& triangles, const std::vector<int>& welded) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.rows());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int side = 0; side < 3; ++side) {
      const int a = welded[triangles(t, side)], b = welded[triangles(t, (side + 1) % 3)];
      if (a != b) uses.push_back({std::min(a, b), std::max(a, b), int(t), a < b});
    }
  tbb::parallel_sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle, a.forward) < std::tie(b.low, b.high, b.triangle, b.forward);
  });
  return uses;
}

DisjointSets::DisjointSets(std::size_t n) : parent_(n) {
  std::iota(parent_.begin(), parent_.end(), 0);
}

int DisjointSets::root(int i) {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

void DisjointSets::merge(int a, int b) {
  a = root(a);
  b = root(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

std::pair<std::vector<int>, int> triangle_components(const Triangles& triangles, const std::vector<int>& welded) {
  DisjointSets sets(welded.size());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int corner = 1; corner < 3; ++corner) sets.merge(welded[triangles(t, 0)], welded[triangles(t, corner)]);
  std::vector<int> number_of_root(welded.size(), -1), component(triangles.rows());
  int num_components = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    int& number = number_of_root[sets.root(welded[triangles(t, 0)])];
    if (number < 0) number = num_components++;
    component[t] = number;
  }
  return {component, num_components};
}

Triangles oriented_consistently(const TriangleMesh& mesh, const std::vector<int>& welded, int* num_turned) {
  Triangles triangles = mesh.triangles;
  for (int& corner : triangles.reshaped<Eigen::RowMajor>()) corner = welded[corner];
  if (num_turned) *num_turned = 0;

  // neighbours across plain edges, with whether their directions disagree
  struct Neighbour {
    int triangle = -1;
    bool disagrees = false;
  };
  std::vector<std::array<Neighbour, 3>> neighbours(triangles.rows());
  std::vector<char> num_neighbours(triangles.rows(), 0);
  bool any_disagrees = false;
  for_each_edge(edge_uses(mesh.triangles, welded), [&](auto first, auto last) {
    if (last - first != 2 || first[0].triangle == first[1].triangle) return;
    const bool disagrees = first[0].forward == first[1].forward;
    any_disagrees |= disagrees;
    for (int k = 0; k < 2; ++k) {
      char& n = num_neighbours[first[k].triangle];
      neighbours[first[k].triangle][std::size_t(n++)] = {first[1 - k].triangle, disagrees};
    }
  });
  if (!any_disagrees) return triangles;

  // flood every patch; then turn the side of it that has the smaller area
  std::vector<char> side(triangles.rows(), -1);
  std::vector<int> patch;
  for (int seed = 0; seed < int(triangles.rows()); ++seed) {
    if (side[seed] >= 0) continue;
    side[seed] = 0;
    patch.assign(1, seed);
    double area[2] = {0, 0};
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const int t = patch[i];
      area[side[t] == 0 ? 0 : 1] += triangle_area(mesh.positions, triangles.row(t));
      for (int k = 0; k < num_neighbours[t]; ++k) {
        const Neighbour& neighbour = neighbours[t][std::size_t(k)];
        if (side[neighbour.triangle] >= 0) continue;
        side[neighbour.triangle] = char(side[t] ^ int(neighbour.disagrees));
        patch.push_back(neighbour.triangle);
      }
    }
    const int turned = area[1] <= area[0] ? 1 : 0;
    for (int t : patch)
      if (side[t] == turned) {
        std::swap(triangles(t, 1), triangles(t, 2));
        if (num_turned) ++*num_turned;
      }
  }
  return triangles;
}

double signed_volume(const Points& positions, const Triangles& triangles) {
  if (positions.rows() == 0) return 0;
  const Vector3d centre = 0.5 * (positions.colwise().minCoeff() + positions.colwise().maxCoeff()).transpose();
  double six_volumes = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Vector3d a = positions.row(triangles(t, 0)).transpose() - centre;
    const Vector3d b = positions.row(triangles(t, 1)).transpose() - centre;
    const Vector3d c = positions.row(triangles(t, 2)).transpose() - centre;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) area += triangle_area(mesh.positions, mesh.triangles.row(t));
  return area;
}

}  // namespace umax
