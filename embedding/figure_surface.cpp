#include "embedding/figure_surface.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <vector>

namespace umax {
namespace {

constexpr int leaf_width = openvdb::FloatTree::LeafNodeType::DIM;
constexpr double slack = 1.5;  // distances of blended ellipsoids may be off by this factor

Vector3d world_point(const openvdb::Coord& ijk, double cell_size) {
  return cell_size * Vector3d(ijk.x(), ijk.y(), ijk.z());
}

/// Origins of the grid's leaves that the surface may cross, in lexicographic order.
std::vector<openvdb::Coord> crossed_leaves(const DistanceFunction& distance, const SurfaceOptions& options) {
  const double leaf_size = leaf_width * options.cell_size;
  const double reach = slack * leaf_size;
  const Eigen::Array3i first = (options.min.array() / leaf_size).floor().cast<int>() - 1;
  const Eigen::Array3i count = (options.max.array() / leaf_size).ceil().cast<int>() + 1 - first;
  const int num_leaves = count.prod();
  const auto origin = [&](int leaf) {
    const Eigen::Array3i at(leaf / (count.y() * count.z()), leaf / count.z() % count.y(), leaf % count.z());
    const Eigen::Array3i ijk = (first + at) * leaf_width;
    return openvdb::Coord(ijk.x(), ijk.y(), ijk.z());
  };
  std::vector<char> crossed(num_leaves, 0);
  tbb::parallel_for(0, num_leaves, [&](int leaf) {
    const Vector3d middle = world_point(origin(leaf), options.cell_size).array() + 0.5 * leaf_size;
    crossed[leaf] = std::abs(distance(middle, reach)) < slack * 0.5 * std::sqrt(3.0) * leaf_size;
  });
  std::vector<openvdb::Coord> leaves;
  for (int leaf = 0; leaf < num_leaves; ++leaf) {
    if (crossed[leaf]) leaves.push_back(origin(leaf));
  }
  return leaves;
}

/// Fills a leaf with distances; blocks of 4 x 4 x 4 cells far from the surface get the background value.
void fill_leaf(const DistanceFunction& distance, double cell_size, double band,
               openvdb::FloatTree::LeafNodeType& leaf) {
  constexpr int width = 4;
  const double block_reach = slack * 0.5 * std::sqrt(3.0) * width * cell_size + band;
  for (int block = 0; block < 8; ++block) {
    const openvdb::Coord corner = leaf.origin().offsetBy(block / 4 * width, block / 2 % 2 * width, block % 2 * width);
    const Vector3d middle = world_point(corner, cell_size).array() + 0.5 * (width - 1) * cell_size;
    const double at_middle = distance(middle, block_reach);
    const bool far_off = std::abs(at_middle) > block_reach;
    for (int cell = 0; cell < width * width * width; ++cell) {
      const openvdb::Coord ijk = corner.offsetBy(cell / (width * width), cell / width % width, cell % width);
      const double value = far_off ? std::copysign(band, at_middle) : distance(world_point(ijk, cell_size), band);
      if (std::abs(value) < band) {
        leaf.setValueOn(ijk, float(value));
      } else {
        leaf.setValueOff(ijk, float(std::copysign(band, value)));
      }
    }
  }
}

openvdb::FloatGrid::Ptr sample_grid(const DistanceFunction& distance, const SurfaceOptions& options) {
  openvdb::initialize();
  const double band = 3 * options.cell_size;
  const auto grid = openvdb::FloatGrid::create(float(band));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(options.cell_size));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
  for (const openvdb::Coord& origin : crossed_leaves(distance, options))
    leaves.push_back(grid->tree().touchLeaf(origin));
  tbb::parallel_for(std::size_t(0), leaves.size(),
                    [&](std::size_t i) { fill_leaf(distance, options.cell_size, band, *leaves[i]); });
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

/// Quads of the zero level set, each cut along its shorter diagonal. OpenVDB winds them clockwise from outside.
TriangleMesh contour(const openvdb::FloatGrid& grid) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, quads, 0.0);
  TriangleMesh mesh;
  mesh.positions.resize(Eigen::Index(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    mesh.positions.row(Eigen::Index(i)) << double(points[i].x()), double(points[i].y()), double(points[i].z());
  }
  mesh.triangles.resize(2 * Eigen::Index(quads.size()), 3);
  for (std::size_t i = 0; i < quads.size(); ++i) {
    const Eigen::Vector4i q(int(quads[i][3]), int(quads[i][2]), int(quads[i][1]), int(quads[i][0]));
    const auto length = [&](int a, int b) { return (mesh.positions.row(q[a]) - mesh.positions.row(q[b])).norm(); };
    const int turn = length(0, 2) <= length(1, 3) ? 0 : 1;
    const auto corner = [&](int k) { return q[(k + turn) % 4]; };
    mesh.triangles.row(2 * Eigen::Index(i)) << corner(0), corner(1), corner(2);
    mesh.triangles.row(2 * Eigen::Index(i) + 1) << corner(0), corner(2), corner(3);
  }
  return mesh;
}

Vector3d gradient(const DistanceFunction& distance, const Vector3d& p, double width, double reach) {
  // differences along the four diagonals of a cube: one evaluation fewer than central differences need twice
  static const Vector3d directions[4] = {{1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, 1, 1}};
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& direction : directions) sum += direction * distance(p + width * direction, reach);
  return sum / (4 * width);
}

/// One Newton step onto the surface, at most half a cell long. Returns the unit normal.
Vector3d project(const DistanceFunction& distance, double cell_size, Eigen::Ref<Eigen::RowVector3d> position) {
  const Vector3d p = position.transpose();
  const Vector3d slope = gradient(distance, p, 0.1 * cell_size, 4 * cell_size);
  const double steepness = std::max(slope.norm(), 0.2);
  const double step = std::clamp(distance(p, 4 * cell_size) / steepness, -0.5 * cell_size, 0.5 * cell_size);
  position -= step * slope.transpose() / steepness;
  return slope.normalized();
}

/// Moves every vertex towards the mean of its neighbours within the surface, then back onto the level set.
void relax(const DistanceFunction& distance, const SurfaceOptions& options, TriangleMesh& mesh) {
  // the ring of each vertex: for a closed surface every neighbour follows the vertex in exactly one triangle
  const Eigen::Index num_vertices = mesh.num_vertices();
  std::vector<int> begin(num_vertices + 1, 0);
  for (const int v : mesh.triangles.reshaped()) ++begin[v + 1];
  for (Eigen::Index v = 0; v < num_vertices; ++v) begin[v + 1] += begin[v];
  std::vector<int> ring(begin.back()), filled(begin.begin(), begin.end() - 1);
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) ring[filled[mesh.triangles(t, k)]++] = mesh.triangles(t, (k + 1) % 3);
  }
  mesh.normals.resize(num_vertices, 3);
  for (int round = 0; round <= options.relaxations; ++round) {
    const Points before = mesh.positions;
    tbb::parallel_for(Eigen::Index(0), num_vertices, [&](Eigen::Index v) {
      if (round > 0) {
        Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
        for (int i = begin[v]; i < begin[v + 1]; ++i) mean += before.row(ring[i]);
        const Eigen::RowVector3d move = mean / (begin[v + 1] - begin[v]) - before.row(v);
        const Eigen::RowVector3d normal = mesh.normals.row(v);
        mesh.positions.row(v) += 0.6 * (move - move.dot(normal) * normal);
      }
      mesh.normals.row(v) = project(distance, options.cell_size, mesh.positions.row(v)).transpose();
    });
  }
}

}  // namespace

TriangleMesh level_set_surface(const DistanceFunction& distance, const SurfaceOptions& options) {
  TriangleMesh mesh = contour(*sample_grid(distance, options));
  relax(distance, options, mesh);
  return mesh;
}

}  // namespace umax
