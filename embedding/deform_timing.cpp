#include "embedding/deform_timing.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "embedding/embedding.h"

namespace umax {
namespace {

// latitudes and longitudes: any number of vertices, poles left open
TriangleMesh graticule(int rows, int columns) {
  TriangleMesh mesh;
  mesh.positions.resize(Eigen::Index(rows) * columns, 3);
  mesh.triangles.resize(2 * Eigen::Index(rows - 1) * columns, 3);
  Eigen::Index next = 0;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double polar = std::numbers::pi * (i + 0.5) / rows, azimuth = 2 * std::numbers::pi * j / columns;
      const int here = i * columns + j, right = i * columns + (j + 1) % columns;
      mesh.positions.row(here) << std::sin(polar) * std::sin(azimuth), std::cos(polar),
          std::sin(polar) * std::cos(azimuth);
      if (i == 0) continue;
      mesh.triangles.row(next++) << here - columns, here, right;
      mesh.triangles.row(next++) << here - columns, right, right - columns;
    }
  return mesh;
}

}  // namespace

DeformTiming time_deform(long long num_vertices, int repeats) {
  const int side = int(std::ceil(std::sqrt(double(std::max(16LL, num_vertices)))));
  const TriangleMesh mesh = graticule(side, side);
  const Lattice lattice = make_box_lattice({7, 7, 7}, {-1.001, -1.001, -1.001}, Vector3d::Constant(2.002 / 7));
  const Embedding embedding = embed(mesh, lattice);
  const Points nodes = lattice.rest_positions.array() + 0.1 * (3 * lattice.rest_positions.array()).sin();

  TriangleMesh out;
  deform(embedding, lattice.hexes, nodes, out);  // sizes the output
  std::vector<double> times;
  for (int i = 0; i < std::max(1, repeats); ++i) {
    const auto start = std::chrono::steady_clock::now();
    deform(embedding, lattice.hexes, nodes, out);
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(times.begin(), times.end());
  return {mesh.num_vertices(), mesh.num_triangles(), times[times.size() / 2], times.front()};
}

}  // namespace umax
