// OpenVDB files for tests.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace umax::test {

/// A grid of voxels with centres at `voxel` times the integers of a box.
struct VdbContent {
  std::string name = "density";
  std::function<double(const Vector3d&)> number = {};       // of a float grid, at the voxel's centre
  std::function<Vector3d(const Vector3d&)> direction = {};  // of a vec3s grid
  double voxel = 0.05;
  Vector3i first{-10, -10, -10}, last{10, 10, 10};  // active voxels, both included; first > last: none
  bool is_level_set = false;
  bool is_integer = false;  // int32, which nobody reads: without voxels
  bool as_halves = false;   // numbers of 16 bits
};

enum class VdbCompression { none, zip, blosc };

/// Inactive voxels have the value -777: whoever looks at them will notice.
void write_vdb(const std::filesystem::path& path, const std::vector<VdbContent>& grids,
               VdbCompression compression = VdbCompression::blosc);

}  // namespace umax::test
