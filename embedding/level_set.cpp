#include "embedding/level_set.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetMeasure.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace umax {
namespace {

// the mesh as meshToVolume() asks for it: corners in index space
struct IndexSpaceMesh {
  const Points& positions;
  const Triangles& triangles;
  Vector3d origin;
  double voxel;

  std::size_t polygonCount() const { return std::size_t(triangles.rows()); }
  std::size_t pointCount() const { return std::size_t(positions.rows()); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t triangle, std::size_t corner, openvdb::Vec3d& point) const {
    const int v = triangles(Eigen::Index(triangle), Eigen::Index(corner));
    for (int axis = 0; axis < 3; ++axis) point[axis] = (positions(v, axis) - origin[axis]) / voxel;
  }
};

}  // namespace

struct LevelSet::Data {
  openvdb::FloatGrid::Ptr grid;
  Vector3d origin;
  double voxel = 0;
};

LevelSet::LevelSet(const Points& positions, const Triangles& triangles, const Vector3d& origin,
                   const LevelSetOptions& options)
    : data_(std::make_unique<Data>()) {
  openvdb::initialize();
  data_->origin = origin;
  data_->voxel = options.voxel;
  const IndexSpaceMesh mesh{positions, triangles, origin, options.voxel};
  const auto transform = openvdb::math::Transform::createLinearTransform(options.voxel);
  const auto band = float(std::max(1.5, options.band_voxels));
  const int flags = options.is_signed ? 0 : int(openvdb::tools::UNSIGNED_DISTANCE_FIELD);
  data_->grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(mesh, *transform, band, band, flags);
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

}  // namespace umax
