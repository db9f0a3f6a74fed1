#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/material.h"
#include "tools/job.h"
#include "tools/run_input.h"
#include "tools/threads.h"
#include "tools/verbs.h"

namespace umax {
namespace {

constexpr double least_filling = 0.05;  // [-] a cell never weighs less than this share (material.mass = "mesh")

/// A limit at time 0 in its three units.
struct LimitReport {
  double energy = 0, density = 0, stretch = 0;  // [J per hex], [J/m^3], [-]
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
  std::string inside_by;  // how inside was told from outside
  std::optional<LimitReport> limit;
  std::vector<std::string> problems;
};

LimitReport limit_in_all_units(const EnergyLimitOptions& limit, double young, double cell_volume) {
  const double value = limit.value.at(0);
  const double density = limit.unit == LimitUnit::energy    ? value / cell_volume
                         : limit.unit == LimitUnit::density ? value
                                                            : density_from_stretch(young, value);
  return {.energy = density * cell_volume, .density = density, .stretch = stretch_from_density(young, density)};
}

BodyReport report_body(const BodyDescription& description, const BodySetup& setup) {
  const MeshReport mesh = report_mesh(setup.shape.mesh);
  const Lattice& lattice = setup.lattice;
  const double cell_volume = lattice.cell_size.prod();
  BodyReport report;
  report.name = setup.name;
  report.vertices = setup.shape.mesh.num_vertices();
  report.triangles = setup.shape.mesh.num_triangles();
  report.cells = lattice.num_hexes();
  report.nodes = lattice.num_nodes();
  report.parts = mesh.num_parts;
  report.islands = setup.cage.num_islands;
  report.size = mesh.box_max - mesh.box_min;
  report.cell_size = lattice.cell_size;
  report.mesh_volume = setup.cage.mesh_volume;
  report.lattice_volume = cell_volume * double(lattice.num_hexes());
  report.mesh_mass = description.material.density * cell_volume * lattice.filled_fraction.cwiseMax(least_filling).sum();
  report.lattice_mass = description.material.density * report.lattice_volume;
  report.young = description.material.young.at(0);
  report.watertight = mesh.watertight;
  report.inside_by = setup.cage.method;
  if (description.limit.kind != LimitKind::none)
    report.limit = limit_in_all_units(description.limit, report.young, cell_volume);
  for (const auto* list : {&mesh.problems, &setup.shape.notes, &setup.cage.notes})
    report.problems.insert(report.problems.end(), list->begin(), list->end());
  if (report.islands > 1)
    report.problems.push_back(
        fmt::format("the cage is in {} pieces that share no node; each falls by itself", report.islands));
  return report;
}

nlohmann::ordered_json cell_size_json(const Vector3d& size) {
  if ((size.array() - size.x()).abs().maxCoeff() <= 1e-9 * size.x()) return size.x();
  return {size.x(), size.y(), size.z()};
}

nlohmann::ordered_json to_json(const BodyReport& report) {
  nlohmann::ordered_json json;
  json["vertices"] = report.vertices;
  json["triangles"] = report.triangles;
  json["parts"] = report.parts;
  json["size_m"] = {report.size.x(), report.size.y(), report.size.z()};
  json["cells"] = report.cells;
  json["nodes"] = report.nodes;
  json["cell_size_m"] = cell_size_json(report.cell_size);
  json["mesh_volume_m3"] = report.mesh_volume;
  json["lattice_volume_m3"] = report.lattice_volume;
  json["mesh_mass_kg"] = report.mesh_mass;
  json["lattice_mass_kg"] = report.lattice_mass;
  json["young_Pa"] = report.young;
  json["watertight"] = report.watertight;
  json["inside_by"] = report.inside_by;
  if (report.limit)
    json["limit"] = {{"energy_J", report.limit->energy},
                     {"density_J_m3", report.limit->density},
                     {"stretch", report.limit->stretch}};
  else
    json["limit"] = nullptr;
  json["problems"] = report.problems;
  return json;
}

void print_body(const BodyReport& report) {
  const Vector3d& size = report.size;
  const Vector3d& cell = report.cell_size;
  fmt::print("{}\n", report.name);
  fmt::print("  surface    {} vertices, {} triangles, {} part{}, {}\n", report.vertices, report.triangles, report.parts,
             report.parts == 1 ? "" : "s", report.watertight ? "watertight" : "not watertight");
  fmt::print("  size       {:.4g} x {:.4g} x {:.4g} m, volume {:.4g} m^3\n", size.x(), size.y(), size.z(),
             report.mesh_volume);
  fmt::print("  cage       {} hexes of {:.4g} x {:.4g} x {:.4g} m, {} nodes, volume {:.4g} m^3 (inside told by {})\n",
             report.cells, cell.x(), cell.y(), cell.z(), report.nodes, report.lattice_volume, report.inside_by);
  fmt::print("  mass       {:.4g} kg by filled cells, {:.4g} kg with full cells\n", report.mesh_mass,
             report.lattice_mass);
  fmt::print("  stiffness  {:.4g} kPa\n", report.young / 1e3);
  if (report.limit)
    fmt::print("  limit      {:.4g} J per hex = {:.4g} J/m^3 = {:.4g} % stretch\n", report.limit->energy,
               report.limit->density, 100 * report.limit->stretch);
  else
    fmt::print("  limit      none\n");
  for (const std::string& problem : report.problems) fmt::print("  problem    {}\n", problem);
}

nlohmann::ordered_json run_json(const std::filesystem::path& run) {
  nlohmann::ordered_json json;
  json["states"] = count_states(run);
  if (const auto record = read_run_record(run / "run.json")) {
    json["steps"] = record->steps;
    json["steps_not_converged"] = record->steps_not_converged;
    json["seconds"] = record->seconds();
    json["peak_memory_bytes"] = record->peak_memory;
    if (record->exit_status) json["exit_status"] = *record->exit_status;
  }
  return json;
}

void print_run(const std::filesystem::path& run) {
  const auto record = read_run_record(run / "run.json");
  fmt::print("run        {} states", count_states(run));
  if (record)
    fmt::print(", {} steps, {} of them not converged, {:.1f} s, {:.0f} MiB", record->steps, record->steps_not_converged,
               record->seconds(), double(record->peak_memory) / 1048576);
  fmt::print("\n");
}

Scene scene_of_input(const std::string& input, InputKind kind, const Options& options) {
  if (kind == InputKind::run) return scene_of_run(input, scene_overrides(options));
  if (kind == InputKind::mesh) return scene_of_mesh(input, 0.5, options);
  return load_scene(input, scene_overrides(options));
}

void print_json(const std::string& input, InputKind kind, const Scene& scene, const std::vector<BodyReport>& reports,
                const std::vector<std::string>& warnings) {
  nlohmann::ordered_json json;
  if (kind == InputKind::mesh) {
    json = to_json(reports.front());
  } else {
    json["scene"] = scene.name;
    json["frames"] = scene.clip.frames;
    for (const BodyReport& report : reports) json["bodies"][report.name] = to_json(report);
    json["problems"] = warnings;
    if (kind == InputKind::run) json["run"] = run_json(input);
  }
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

}  // namespace

int verb_inspect(const Options& options) {
  const ThreadLimit threads(options.threads);
  const std::string input = single_input(options, "mesh, scene or folder of a run");
  const InputKind kind = kind_of_input(input);
  const Scene scene = scene_of_input(input, kind, options);
  const Simulation simulation = set_up(scene);
  std::vector<BodyReport> reports;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    reports.push_back(report_body(scene.bodies[i], simulation.bodies[i]));
  if (options.json) {
    print_json(input, kind, scene, reports, simulation.warnings);
    return 0;
  }
  if (kind != InputKind::mesh)
    fmt::print("scene      {}: {} frames at {:g}/s, {} step{} a frame\n", scene.name, scene.clip.frames, scene.clip.fps,
               scene.clip.substeps, scene.clip.substeps == 1 ? "" : "s");
  if (kind == InputKind::run) print_run(input);
  for (const BodyReport& report : reports) print_body(report);
  return 0;
}

}  // namespace umax
