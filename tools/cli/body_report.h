// What inspect tells of a body: its cage, its hexes, its limits, its maps.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/setup/body_maps.h"
#include "tools/setup/limit_report.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

struct Extremes {
  double least = 0, largest = 0;
};

/// What hexes of a file are, where those of a grid are all alike.
struct HexReport {
  Extremes edge, volume;         // [m], [m^3]
  double scaled_jacobian = 1;    // [-] of the worst hex: 1 for a box, 0 where it begins to be inverted
  double determinant_ratio = 1;  // [-] least over largest det(dX/ds) of the worst hex
  Eigen::Index worst_hex = 0;    // by scaled Jacobian, in the order of the file's hexes
  Extremes young_factor{1, 1}, limit_factor{1, 1};  // [-]
};

/// Everything that inspect tells of a body.
struct BodyReport {
  std::string name;
  Eigen::Index vertices = 0, triangles = 0, cells = 0, nodes = 0;
  int parts = 0, islands = 0;
  Vector3d size{0, 0, 0}, cell_size{0, 0, 0};  // [m]
  double mesh_volume = 0, lattice_volume = 0;  // [m^3]
  double mesh_mass = 0, lattice_mass = 0;      // [kg] as material.mass = "mesh" and "lattice" weigh it
  double young = 0;                            // [Pa]
  bool watertight = false;
  std::string inside_by;            // how inside was told from outside
  std::vector<LimitReport> limits;  // of hexes from a file: of one of the mean volume, without its factor
  std::optional<HexReport> hexes;   // of a file
  std::vector<BodyMap> maps;
  std::vector<std::string> problems;
};

BodyReport report_body(const BodyDescription& description, const BodySetup& setup);

void print_body(const BodyReport& report);

}  // namespace umax
