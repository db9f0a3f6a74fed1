#include "embedding/surface/level_set.h"

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetMeasure.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace umax {
namespace {

/// Corners in index space.
std::vector<openvdb::Vec3s> corners(const Points& positions, const Vector3d& origin, double voxel) {
  std::vector<openvdb::Vec3s> corners(std::size_t(positions.rows()));
  for (std::size_t v = 0; v < corners.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis)
      corners[v][axis] = float((positions(Eigen::Index(v), axis) - origin[axis]) / voxel);
  }
  return corners;
}

std::vector<openvdb::Vec3I> polygons(const Triangles& triangles) {
  std::vector<openvdb::Vec3I> polygons(std::size_t(triangles.rows()));
  for (std::size_t t = 0; t < polygons.size(); ++t) {
    for (int k = 0; k < 3; ++k) polygons[t][k] = openvdb::Index32(triangles(Eigen::Index(t), k));
  }
  return polygons;
}

constexpr int leaf_width = openvdb::FloatTree::LeafNodeType::DIM;
constexpr double slack = 1.5;  // distances of blended ellipsoids may be off by this factor

Vector3d world_point(const openvdb::Coord& ijk, double cell_size) {
  return cell_size * Vector3d(ijk.x(), ijk.y(), ijk.z());
}

/// Origins of the grid's leaves that the surface may cross, in lexicographic order.
std::vector<openvdb::Coord> crossed_leaves(const DistanceFunction& distance, const Vector3d& min, const Vector3d& max,
                                           double cell_size) {
  const double leaf_size = leaf_width * cell_size;
  const double reach = slack * leaf_size;
  const Eigen::Array3i first = (min.array() / leaf_size).floor().cast<int>() - 1;
  const Eigen::Array3i count = (max.array() / leaf_size).ceil().cast<int>() + 1 - first;
  const int num_leaves = count.prod();
  const auto origin = [&](int leaf) {
    const Eigen::Array3i at(leaf / (count.y() * count.z()), leaf / count.z() % count.y(), leaf % count.z());
    const Eigen::Array3i ijk = (first + at) * leaf_width;
    return openvdb::Coord(ijk.x(), ijk.y(), ijk.z());
  };
  std::vector<char> crossed(num_leaves, 0);
  tbb::parallel_for(0, num_leaves, [&](int leaf) {
    const Vector3d middle = world_point(origin(leaf), cell_size).array() + 0.5 * leaf_size;
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

openvdb::FloatGrid::Ptr sample_grid(const DistanceFunction& distance, const Vector3d& min, const Vector3d& max,
                                    double cell_size) {
  openvdb::initialize();
  const double band = 3 * cell_size;
  // made in libopenvdb: a grid made here would have our compiler make all that a tree can do
  const auto grid =
      openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::GridBase::createGrid(openvdb::FloatGrid::gridType()));
  grid->tree().root().setBackground(float(band), /*updateChildNodes=*/false);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(cell_size));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
  for (const openvdb::Coord& origin : crossed_leaves(distance, min, max, cell_size))
    leaves.push_back(grid->tree().touchLeaf(origin));
  tbb::parallel_for(std::size_t(0), leaves.size(),
                    [&](std::size_t i) { fill_leaf(distance, cell_size, band, *leaves[i]); });
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

/// Quads of the zero level set, each cut along its shorter diagonal. OpenVDB winds them clockwise from outside.
TriangleMesh triangles_of(const openvdb::FloatGrid& grid) {
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
    const Eigen::Vector4i q{int(quads[i][3]), int(quads[i][2]), int(quads[i][1]), int(quads[i][0])};
    const auto length = [&](int a, int b) { return (mesh.positions.row(q[a]) - mesh.positions.row(q[b])).norm(); };
    const int turn = length(0, 2) <= length(1, 3) ? 0 : 1;
    const auto corner = [&](int k) { return q[(k + turn) % 4]; };
    mesh.triangles.row(2 * Eigen::Index(i)) << corner(0), corner(1), corner(2);
    mesh.triangles.row(2 * Eigen::Index(i) + 1) << corner(0), corner(2), corner(3);
  }
  return mesh;
}

}  // namespace

struct LevelSet::Data {
  openvdb::FloatGrid::Ptr grid;
  Vector3d origin;
  double voxel = 0;
};

LevelSet::LevelSet(const Points& positions, const Triangles& triangles, const Vector3d& origin,
                   const LevelSetOptions& options)
    : data_(std::make_unique<Data>()) {
  if (!(options.voxel >= LevelSetOptions::smallest_voxel))
    throw Error(Fault::bad_data, {"level set", "is too fine", fmt::format("voxels of {:g} m", options.voxel),
                                  "ask for fewer samples, or give a larger mesh"});
  openvdb::initialize();
  data_->origin = origin;
  data_->voxel = options.voxel;
  // of all forms of a mesh, this one's meshToVolume() lies compiled in libopenvdb: a minute less for our compiler
  const auto points = corners(positions, origin, options.voxel);
  const auto faces = polygons(triangles);
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> mesh(points, faces);
  openvdb::util::NullInterrupter no_interrupter;
  const auto transform = openvdb::math::Transform::createLinearTransform(options.voxel);
  const auto band = float(std::max(1.5, options.band_voxels));
  const int flags = options.is_signed ? 0 : int(openvdb::tools::UNSIGNED_DISTANCE_FIELD);
  data_->grid =
      openvdb::tools::meshToVolume<openvdb::FloatGrid>(no_interrupter, mesh, *transform, band, band, flags, nullptr);
}

LevelSet::~LevelSet() = default;
LevelSet::LevelSet(LevelSet&&) noexcept = default;
LevelSet& LevelSet::operator=(LevelSet&&) noexcept = default;

double LevelSet::voxel() const {
  return data_->voxel;
}

double LevelSet::volume() const {
  if (data_->grid->activeVoxelCount() == 0 || data_->grid->getGridClass() != openvdb::GRID_LEVEL_SET) return 0;
  return std::abs(double(openvdb::tools::levelSetVolume(*data_->grid)));
}

std::vector<float> LevelSet::sample(const Points& points) const {
  std::vector<float> distances(std::size_t(points.rows()));
  tbb::parallel_for(tbb::blocked_range<Eigen::Index>(0, points.rows(), 4096), [&](const auto& range) {
    const auto accessor = data_->grid->getConstAccessor();
    for (Eigen::Index p = range.begin(); p < range.end(); ++p) {
      const Vector3d s = (points.row(p).transpose() - data_->origin) / data_->voxel;
      distances[std::size_t(p)] = openvdb::tools::BoxSampler::sample(accessor, openvdb::Vec3d(s[0], s[1], s[2]));
    }
  });
  return distances;
}

std::vector<float> LevelSet::dense(const Vector3i& first, const Vector3i& size) const {
  const Vector3i last = first + size - Vector3i::Ones();
  const openvdb::CoordBBox box(openvdb::Coord(first[0], first[1], first[2]), openvdb::Coord(last[0], last[1], last[2]));
  const std::size_t num_values = std::size_t(size[0]) * std::size_t(size[1]) * std::size_t(size[2]);
  std::vector<float> values(num_values);
  openvdb::tools::Dense<float, openvdb::tools::LayoutZYX> dense(box, values.data());
  openvdb::tools::copyToDense(*data_->grid, dense);
  return values;
}

TriangleMesh contour(const DistanceFunction& distance, const Vector3d& min, const Vector3d& max, double cell_size) {
  return triangles_of(*sample_grid(distance, min, max, cell_size));
}

}  // namespace umax
