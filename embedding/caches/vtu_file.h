// Meshes of hexes with data on them, for ParaView and VTK: .vtu files (binary, appended), and the .pvd that says at which
// time each of them is.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.h"

namespace umax {

/// Numbers of each hex, or of each node.
struct DataArray {
  std::string name;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;  // one row each
};

/// Hexes in one frame.
struct HexFrame {
  double time = 0;  // [s]
  Points nodes;     // #N x 3
  Hexes hexes;      // #E x 8 in our node order: core/element/hexahedron.h
  std::vector<DataArray> node_data, hex_data;
};

/// The .vtu file's bytes, numbers in double precision.
std::string vtu_bytes(const HexFrame& frame);

/// A part of a .pvd file: one file at one time.
struct PvdEntry {
  double time = 0;   // [s]
  int part = 0;      // of several bodies
  std::string file;  // relative to the .pvd
};
std::string pvd_text(const std::vector<PvdEntry>& entries);

}  // namespace umax
