// Numbers and directions in space from OpenVDB files (.vdb).
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace umax {

/// What a grid says at points. A grid reaches as far as its active voxels, each a box around its centre.
struct GridSamples {
  std::vector<char> inside;  // #P whether an active voxel holds the point
  MatrixXd values;           // #P x 1 or #P x 6, trilinear between active voxels alone; 0 outside
};

/// Points may be asked from any number of threads.
class VdbGrid {
 public:
  enum class Kind {
    number,     // float; the values are the voxels', none of them negative
    direction,  // vec3s; the values are f f^T (xx, yy, zz, xy, xz, yz) of the unit vectors: a direction has no sign
  };

  /// name: of the grid; empty: the file's only one of this kind. Throws Error: not_found (the file is missing, a
  /// folder, not readable), bad_data (damaged, no or several such grids, none of this name, another kind, a level set,
  /// no active voxel, values that are not finite or, of numbers, negative).
  VdbGrid(const std::filesystem::path& path, const std::string& name, Kind kind);
  ~VdbGrid();
  VdbGrid(VdbGrid&&) noexcept;
  VdbGrid& operator=(VdbGrid&&) noexcept;

  /// points: #P x 3 in the file's own coordinates.
  GridSamples sample(const Points& points) const;

  /// Corners of the box around the active voxels, in the file's own coordinates.
  Eigen::AlignedBox3d box() const;
  const std::string& name() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Whether the file's ending says that it is OpenVDB's.
bool is_vdb_file(const std::filesystem::path& path);

}  // namespace umax
