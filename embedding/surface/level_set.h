// Meshes as OpenVDB level sets, signed distances near the surface, inside or outside everywhere; and the way back.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

struct LevelSetOptions {
  static constexpr double smallest_voxel = 2e-5;  // [m] OpenVDB takes smaller ones for none

  double voxel = 0.01;     // [m] edge of a voxel
  double band_voxels = 3;  // [voxels] distances (to 1 % of a voxel) reach this far on both sides; then they are cut off
  bool is_signed = true;   // false: distances without sign
};

/// Points may be asked from any number of threads.
class LevelSet {
 public:
  /// positions: #P x 3 [m]; triangles: #T x 3. Voxel corners lie at origin + voxel * integers. Throws Error (bad_data)
  /// for voxels below smallest_voxel.
  LevelSet(const Points& positions, const Triangles& triangles, const Vector3d& origin, const LevelSetOptions& options);
  ~LevelSet();
  LevelSet(LevelSet&&) noexcept;
  LevelSet& operator=(LevelSet&&) noexcept;

  double voxel() const;
  /// [m^3] enclosed by the zero crossing of a signed field.
  double volume() const;
  /// Distance [m] at each point, trilinear, negative inside, cut off at the band.
  std::vector<float> sample(const Points& points) const;
  /// Values [m] at origin + voxel * (first + (i, j, k)) for i, j, k < size; index (i * size.y + j) * size.z + k.
  std::vector<float> dense(const Vector3i& first, const Vector3i& size) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Signed distance [m] at a point, right where it is at most `reach` [m]; called from several threads.
using DistanceFunction = std::function<double(const Vector3d& p, double reach)>;

/// Triangles of a distance function's zero level set within the box min .. max [m], by dual contouring of cells with
/// edge cell_size [m]: counter-clockwise from outside, no normals. The same bytes for any number of threads.
TriangleMesh contour(const DistanceFunction& distance, const Vector3d& min, const Vector3d& max, double cell_size);

}  // namespace umax
