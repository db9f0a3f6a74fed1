// What kind of surface a mesh is: closed or open, in how many parts, with which faults.
#pragma once

#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// All counts are made after vertices at exactly the same position have been welded.
struct MeshReport {
  bool watertight = false;           // every edge has exactly two triangles that run through it in opposite directions
  int num_parts = 0;                 // connected components
  int num_boundary_edges = 0;        // edges with one triangle
  int num_non_manifold_edges = 0;    // edges with three or more triangles
  int num_inconsistent_edges = 0;    // edges with two triangles that run the same way
  int num_degenerate_triangles = 0;  // without area
  int num_duplicate_vertices = 0;    // vertices at the position of an earlier one
  int num_unused_vertices = 0;       // in no triangle
  double signed_volume = 0;  // [m^3] negative: inside out; of an open mesh: about the centre of its bounding box
  double area = 0;           // [m^2]
  Vector3d box_min{0, 0, 0}, box_max{0, 0, 0};  // [m]
  std::vector<std::string> problems;            // one sentence each, empty for a sound closed mesh
};

MeshReport report_mesh(const TriangleMesh& mesh);

}  // namespace umax
