#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "render/image/image_io.h"
#include "tools/cli/body_report.h"
#include "tools/cli/mesh_scene.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/pictures/map_picture.h"
#include "tools/pictures/overlap_picture.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_record.h"
#include "tools/system/threads.h"

namespace umax {
namespace {

nlohmann::ordered_json cell_size_json(const Vector3d& size) {
  if ((size.array() - size.x()).abs().maxCoeff() <= 1e-9 * size.x()) return size.x();
  return {size.x(), size.y(), size.z()};
}

nlohmann::ordered_json to_json(const HexReport& report) {
  const auto both = [](const Extremes& extremes) { return std::array{extremes.least, extremes.largest}; };
  nlohmann::ordered_json json;
  json["edge_m"] = both(report.edge);
  json["volume_m3"] = both(report.volume);
  json["worst_scaled_jacobian"] = report.scaled_jacobian;
  json["worst_hex"] = report.worst_hex;
  json["worst_determinant_ratio"] = report.determinant_ratio;
  json["young_factor"] = both(report.young_factor);
  json["limit_factor"] = both(report.limit_factor);
  return json;
}

nlohmann::ordered_json to_json(const LimitReport& report) {
  const auto finite = [](double strain) {
    return std::isfinite(strain) ? nlohmann::ordered_json(strain) : nlohmann::ordered_json(nullptr);
  };
  return {{"energy_J", report.energy},
          {"density_J_m3", report.density},
          {"stretch", report.strains.stretch},
          {"shear", finite(report.strains.shear)},
          {"volume_change", finite(report.strains.volume_change)},
          {"kind", report.kind == LimitKind::soft ? "soft" : "hard"},
          {"measure", report.measure == LimitMeasure::peak ? "peak" : "mean"}};
}

// under "limit", and those of parts under "part_limits" by name; what it is at later keys, in a list under "keys"
void add_limit(const LimitReport& report, nlohmann::ordered_json& body) {
  const std::string name = limit_name(report.part);
  nlohmann::ordered_json& limit =
      report.part == EnergyPart::whole ? body["limit"] : body["part_limits"][name.substr(name.find('.') + 1)];
  if (limit.is_null()) {
    limit = to_json(report);
    return;
  }
  limit["keys"].push_back(to_json(report));
  limit["keys"].back()["time_s"] = report.time;
}

nlohmann::ordered_json to_json(const BodyMap& map) {
  return {{"key", map.key},
          {"source", map.source},
          {"factor", {map.hexes.factors.minCoeff(), map.hexes.factors.maxCoeff()}},
          {"hexes_outside", map.hexes.num_outside},
          {"hexes_clamped", map.hexes.num_clamped}};
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
  if (report.hexes) json["hexes"] = to_json(*report.hexes);
  json["mesh_volume_m3"] = report.mesh_volume;
  json["lattice_volume_m3"] = report.lattice_volume;
  json["mesh_mass_kg"] = report.mesh_mass;
  json["lattice_mass_kg"] = report.lattice_mass;
  json["young_Pa"] = report.young;
  json["watertight"] = report.watertight;
  json["inside_by"] = report.inside_by;
  json["limit"] = nullptr;  // of the whole energy
  for (const LimitReport& limit : report.limits) add_limit(limit, json);
  json["maps"] = nlohmann::ordered_json::array();
  for (const BodyMap& map : report.maps) json["maps"].push_back(to_json(map));
  json["problems"] = report.problems;
  return json;
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
    json["ended"] = how_it_ended(*record, workers_in_run(run));
    json["calls_killed"] = record->calls_killed;
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
  if (record) fmt::print("ended      {}\n", how_it_ended(*record, workers_in_run(run)));
}

Scene scene_of_input(const std::string& input, InputKind kind, const Options& options) {
  if (kind == InputKind::run) return scene_of_run(input, scene_overrides(options));
  if (kind == InputKind::mesh) return scene_of_mesh(input, 0.5, options);
  return load_scene(input, scene_overrides(options));
}

void print_json(const std::string& input, InputKind kind, const Scene& scene, const std::vector<BodyReport>& reports,
                const std::vector<std::string>& warnings, const std::optional<std::filesystem::path>& picture,
                bool is_map) {
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
  if (picture) json[is_map ? "map_picture" : "overlap_picture"] = picture->string();
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

/// Where the picture of --map or --picture goes; nothing without them.
std::optional<std::filesystem::path> place_of_picture(const Scene& scene, const Options& options) {
  if (options.map && options.picture)
    throw Error(Fault::usage, {.where = "--picture",
                               .what = "is another picture than that of --map",
                               .remedy = "draw them one after the other"});
  if (!options.map && !options.picture) {
    if (!options.output && !options.overwrite) return std::nullopt;
    throw Error(Fault::usage, {.where = options.output ? "-o" : "--overwrite",
                               .what = "is for the picture of --map or --picture",
                               .remedy = "add --map limit, --map young or --picture"});
  }
  std::filesystem::path path = options.output.value_or(
      options.map ? fmt::format("{}-{}-map.png", scene.name, *options.map) : scene.name + "-overlaps.png");
  require_new_file(path, options);
  return path;
}

void draw(const Simulation& simulation, const Options& options, const std::filesystem::path& path) {
  if (options.picture) {
    write_png(path, overlap_picture(simulation, options.threads.value_or(0)));
    return;
  }
  const bool limit = options.map == "limit";
  write_png(path, map_picture(simulation, limit ? simulation.model.limit_factor : simulation.model.young_factor,
                              limit ? "× limit" : "× stiffness", options.threads.value_or(0)));
}

int inspect(const Options& options) {
  const ThreadLimit threads(options.threads);
  const std::string input = single_input(options, "mesh, scene or folder of a run");
  const InputKind kind = kind_of_input(input);
  const Scene scene = scene_of_input(input, kind, options);
  const auto picture = place_of_picture(scene, options);
  const Simulation simulation = set_up(scene);
  if (picture) draw(simulation, options, *picture);
  std::vector<BodyReport> reports;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    reports.push_back(report_body(scene.bodies[i], simulation.bodies[i]));
  if (options.json) {
    print_json(input, kind, scene, reports, simulation.warnings, picture, options.map.has_value());
    return 0;
  }
  if (kind != InputKind::mesh)
    fmt::print("scene      {}: {} frames at {:g}/s, {} step{} a frame\n", scene.name, scene.clip.frames, scene.clip.fps,
               scene.clip.substeps, scene.clip.substeps == 1 ? "" : "s");
  if (kind == InputKind::run) print_run(input);
  for (const BodyReport& report : reports) print_body(report);
  if (picture) fmt::print("picture    {}\n", picture->string());
  return 0;
}

}  // namespace

Verb inspect_verb() {
  return {.name = "inspect",
          .usage = "MESH|SCENE|DIR",
          .summary = "sizes, cage, mass, limits, problems",
          .details =
              "Tells what a mesh, a scene or a run is, and what is wrong with it. Exit code 65 if it cannot be used. "
              "With --map it draws the factors of limit.map or material.young_map on the surface, from the front and "
              "from the back; with --picture, where bodies are inside each other at the start, and how deep.",
          .examples = {"umax inspect bunny.ply --json",
                       "umax inspect figure --set body.figure.limit.map=mesh --map limit -o paint.png",
                       "umax inspect heap --picture -o overlaps.png"},
          .arguments = {.words = scene_names, .endings = {"*"}},
          .options = {"--output", "--set", "--overwrite", "--height", "--unit", "--up", "--cells", "--json", "--map",
                      "--picture", "--threads", "--quiet", "--verbose"},
          .run = inspect};
}

}  // namespace umax
