#include "tools/cli/body_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/element/hexahedron.h"
#include "core/element/material.h"
#include "core/model/filling.h"
#include "embedding/cage/hex_cage.h"

namespace umax {
namespace {

Extremes extremes(const VectorXd& values) {
  return values.size() > 0 ? Extremes{values.minCoeff(), values.maxCoeff()} : Extremes{1, 1};
}

HexReport report_hexes(const BodySetup& setup, const VectorXd& volumes) {
  HexReport report;
  report.volume = extremes(volumes);
  report.young_factor = extremes(setup.shape.hexes->mesh.young_factor);
  report.limit_factor = extremes(setup.shape.hexes->mesh.limit_factor);
  report.edge = {std::numeric_limits<double>::infinity(), 0};
  double worst = std::numeric_limits<double>::infinity();
  for (Eigen::Index e = 0; e < setup.lattice.num_hexes(); ++e) {
    const Matrix8x3d nodes = rest_nodes(setup.lattice, e);
    const HexQuality quality = hex_quality(nodes);
    report.determinant_ratio = std::min(report.determinant_ratio, quality.determinant_ratio);
    if (quality.scaled_jacobian < worst) {
      worst = quality.scaled_jacobian;
      report.worst_hex = e;
    }
    for (int n = 0; n < 8; ++n)
      for (int bit = 1; bit < 8; bit <<= 1) {
        const double edge = (nodes.row(n) - nodes.row(n ^ bit)).norm();
        report.edge = {std::min(report.edge.least, edge), std::max(report.edge.largest, edge)};
      }
  }
  report.scaled_jacobian = worst;
  return report;
}

void print_hexes(const BodyReport& report) {
  const HexReport& hexes = *report.hexes;
  fmt::print(
      "  cage       {} hexes with edges of {:.4g} to {:.4g} m, {} nodes, volume {:.4g} m^3 (inside told by {})\n",
      report.cells, hexes.edge.least, hexes.edge.largest, report.nodes, report.lattice_volume, report.inside_by);
  fmt::print(
      "  hexes      {:.4g} to {:.4g} m^3; worst scaled Jacobian {:.3g} (hex {}), worst ratio of determinants {:.3g}\n",
      hexes.volume.least, hexes.volume.largest, hexes.scaled_jacobian, hexes.worst_hex, hexes.determinant_ratio);
  for (const auto& [name, factor] :
       {std::pair("Young's modulus", hexes.young_factor), std::pair("limit", hexes.limit_factor)})
    if (factor.least != 1 || factor.largest != 1)
      fmt::print("  factors    {:.4g} to {:.4g} on the {}\n", factor.least, factor.largest, name);
}

void print_limit(const LimitReport& limit, const std::string& hex) {
  std::string how = limit.kind == LimitKind::soft ? "; soft" : "";
  if (limit.measure == LimitMeasure::peak) how += "; at the worst of 8 points of the hex";
  if (limit.time > 0) how += fmt::format("; at {:g} s", limit.time);
  fmt::print("  {:<10} {}{}\n", limit_name(limit.part), limit_text(limit, hex), how);
}

}  // namespace

BodyReport report_body(const BodyDescription& description, const BodySetup& setup) {
  const MeshReport mesh = report_mesh(setup.shape.mesh);
  const Lattice& lattice = setup.lattice;
  const VectorXd volumes =
      lattice.is_regular() ? VectorXd::Constant(lattice.num_hexes(), lattice.cell_size.prod()) : hex_volumes(lattice);
  const double cell_volume = mean_hex_volume(lattice);
  BodyReport report;
  report.name = setup.name;
  report.vertices = setup.shape.mesh.num_vertices();
  report.triangles = setup.shape.mesh.num_triangles();
  report.cells = lattice.num_hexes();
  report.nodes = lattice.num_nodes();
  report.parts = mesh.num_parts;
  report.islands = setup.cage.num_islands;
  report.size = mesh.box_max - mesh.box_min;
  report.cell_size = lattice.is_regular() ? lattice.cell_size : Vector3d::Constant(std::cbrt(cell_volume)).eval();
  if (!lattice.is_regular()) report.hexes = report_hexes(setup, volumes);
  report.mesh_volume = setup.cage.mesh_volume;
  report.lattice_volume = cell_volume * double(lattice.num_hexes());
  const VectorXd filling = weighing_fractions(lattice);
  report.mesh_mass =
      description.material.density.at(0) * (lattice.is_regular() ? cell_volume * filling.sum() : filling.dot(volumes));
  report.lattice_mass = description.material.density.at(0) * report.lattice_volume;
  report.young = description.material.young.at(0);
  report.watertight = mesh.watertight;
  report.inside_by = setup.cage.method;
  report.limits = limit_reports(description, cell_volume);
  for (const auto* map : {&setup.young_map, &setup.limit_map})
    if (*map) report.maps.push_back(**map);
  for (const auto* list : {&mesh.problems, &setup.shape.notes, &setup.cage.notes})
    report.problems.insert(report.problems.end(), list->begin(), list->end());
  return report;
}

void print_body(const BodyReport& report) {
  const Vector3d& size = report.size;
  const Vector3d& cell = report.cell_size;
  fmt::print("{}\n", report.name);
  fmt::print("  surface    {} vertices, {} triangles, {} part{}, {}\n", report.vertices, report.triangles, report.parts,
             report.parts == 1 ? "" : "s", report.watertight ? "watertight" : "not watertight");
  fmt::print("  size       {:.4g} x {:.4g} x {:.4g} m, volume {:.4g} m^3\n", size.x(), size.y(), size.z(),
             report.mesh_volume);
  if (report.hexes)
    print_hexes(report);
  else
    fmt::print("  cage       {} hexes of {:.4g} x {:.4g} x {:.4g} m, {} nodes, volume {:.4g} m^3 (inside told by {})\n",
               report.cells, cell.x(), cell.y(), cell.z(), report.nodes, report.lattice_volume, report.inside_by);
  fmt::print("  mass       {:.4g} kg by filled cells, {:.4g} kg with full cells\n", report.mesh_mass,
             report.lattice_mass);
  fmt::print("  stiffness  {:.4g} kPa\n", report.young / 1e3);
  for (const LimitReport& limit : report.limits) print_limit(limit, report.hexes ? "hex of the mean volume" : "hex");
  if (report.limits.empty()) fmt::print("  limit      none\n");
  for (const BodyMap& map : report.maps) fmt::print("  map        {}: {}\n", map.key, describe(map));
  for (const std::string& problem : report.problems) fmt::print("  problem    {}\n", problem);
}

}  // namespace umax
