// Which points are inside a mesh, whatever its faults: OpenVDB's level set where its volume can be trusted, else
// winding numbers of the capped surface.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"
#include "embedding/surface/level_set.h"
#include "embedding/surface/winding.h"

namespace umax {

struct Solid {
  ClosedSurface surface;
  std::optional<LevelSet> level_set;  // set only when it decides what is inside
  double mesh_volume = 0;          // [m^3] enclosed by the surface as it stands, holes capped, overlaps counted twice
  double level_set_volume = 0;     // [m^3] 0: no level set was made
  double volume = 0;               // [m^3] of the inside, by the method chosen
  double area = 0;                 // [m^2]
  std::string method;              // "level set" or "winding numbers"
  std::vector<std::string> notes;  // what was found and done; empty for a sound closed mesh
};

/// surface: close_surface(mesh). voxel [m]: of the level set; where it would take too much memory, larger ones up to
/// twice that, or no level set at all.
Solid make_solid(const TriangleMesh& mesh, ClosedSurface surface, double voxel);

/// Points at origin + spacing * (i, j, k).
struct PointGrid {
  Vector3d origin{0, 0, 0}, spacing{1, 1, 1};  // [m]
  Vector3i size{0, 0, 0};
};

/// Which of the grid points (i, j, k), sorted and without duplicates, are inside.
std::vector<char> are_inside(const Solid& solid, const PointGrid& grid, const std::vector<std::array<int, 3>>& points);

}  // namespace umax
