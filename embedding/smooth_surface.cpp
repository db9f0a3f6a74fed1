#include "embedding/smooth_surface.h"

#include <array>
#include <cassert>
#include <vector>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index block_size = 1024;

using Octants = std::array<int, 8>;        // cells around a node: bit 2 for x, 1 for y, 0 for z beyond it; -1: none
using NodeData = std::array<Vector3d, 8>;  // bit 2: differentiated along x, 1: y, 0: z; 0: the place

std::vector<Octants> octants_of(const Lattice& lattice) {
  Octants none;
  none.fill(-1);
  std::vector<Octants> octants(std::size_t(lattice.num_nodes()), none);
  for (int e = 0; e < int(lattice.num_hexes()); ++e)
    for (int n = 0; n < 8; ++n) octants[std::size_t(lattice.hexes(e, n))][std::size_t(7 - n)] = e;
  return octants;
}

// the difference along `axes` in a cell, at its corner n
Vector3d cell_difference(const Hexes& hexes, int cell, int n, int axes, const Points& nodes) {
  Vector3d sum(0, 0, 0);
  // over the corners that differ from n along these axes alone
  for (int k = 0; k < 8; ++k) {
    if ((k & axes) != k) continue;
    const int corner = (n & ~axes) | k;
    const bool is_negative = (__builtin_popcount(unsigned(axes & ~k)) & 1) != 0;
    const Vector3d place = nodes.row(hexes(cell, corner)).transpose();
    sum += is_negative ? Vector3d(-place) : place;
  }
  return sum;
}

// mean over the sides of the node, along these axes, that have a cell: all cells of one side have the same difference
Vector3d node_difference(const Lattice& lattice, const Octants& octants, int axes, const Points& nodes) {
  Vector3d sum(0, 0, 0);
  int count = 0;
  for (int side = 0; side < 8; ++side) {
    if ((side & axes) != side) continue;
    for (int octant = 0; octant < 8; ++octant) {
      const int cell = octants[std::size_t(octant)];
      if ((octant & axes) != side || cell < 0) continue;
      sum += cell_difference(lattice.hexes, cell, 7 - octant, axes, nodes);
      ++count;
      break;
    }
  }
  return count > 0 ? Vector3d(sum / count) : sum;
}

std::vector<NodeData> data_of_nodes(const Lattice& lattice, const Points& nodes) {
  const std::vector<Octants> octants = octants_of(lattice);
  std::vector<NodeData> data(octants.size());
  parallel_blocks(Eigen::Index(data.size()), block_size, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index i = first; i < last; ++i) {
      data[std::size_t(i)][0] = nodes.row(i).transpose();
      for (int axes = 1; axes < 8; ++axes)
        data[std::size_t(i)][std::size_t(axes)] = node_difference(lattice, octants[std::size_t(i)], axes, nodes);
    }
  });
  return data;
}

// [corner's bit][value or slope] of one coordinate
using Hermite = std::array<std::array<double, 2>, 2>;

Hermite hermite(double s) {
  const double r = 1 - s;
  return {{{(1 + 2 * s) * r * r, s * r * r}, {s * s * (3 - 2 * s), s * s * (s - 1)}}};
}

Vector3d evaluate(const std::vector<NodeData>& data, const Hexes& hexes, int hex, const Vector3d& s) {
  const std::array<Hermite, 3> h{hermite(s.x()), hermite(s.y()), hermite(s.z())};
  Vector3d sum(0, 0, 0);
  for (unsigned n = 0; n < 8; ++n) {
    const NodeData& node = data[std::size_t(hexes(hex, int(n)))];
    for (unsigned d = 0; d < 8; ++d)
      sum += h[0][n >> 2][d >> 2] * h[1][n >> 1 & 1][d >> 1 & 1] * h[2][n & 1][d & 1] * node[d];
  }
  return sum;
}

}  // namespace

Points smooth_positions(const VectorXi& hex, const Points& local, const Lattice& lattice, const Points& nodes) {
  assert(lattice.is_regular());
  const std::vector<NodeData> data = data_of_nodes(lattice, nodes);
  Points positions(local.rows(), 3);
  parallel_blocks(local.rows(), block_size, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index p = first; p < last; ++p)
      positions.row(p) = evaluate(data, lattice.hexes, hex[p], local.row(p).transpose()).transpose();
  });
  return positions;
}

void deform_smoothly(const Embedding& embedding, const Lattice& lattice, const Points& nodes, TriangleMesh& out) {
  out.positions = smooth_positions(embedding.hex, embedding.local, lattice, nodes);
  out.normals.resize(out.positions.rows(), 3);
  parallel_blocks(out.positions.rows(), block_size, [&](Eigen::Index first, Eigen::Index last) {
    compute_normals(embedding.fans, out.positions, first, last, out.normals);
  });
}

}  // namespace umax
