#include "tools/run/run_motion.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>

#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/files/write_file.h"
#include "scenes/resolved_scene.h"
#include "tools/pictures/drawn_surface.h"
#include "tools/pictures/shot.h"
#include "tools/setup/state_file.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

/// Motion, and what it is of.
struct KeptMotion {
  int states = 0;        // 1 .. states
  std::string surfaces;  // digest of what they show
  std::string heatmap;   // whose range it is
  RunMotion motion;
};

std::string heatmap_name(const Simulation& simulation) {
  constexpr std::array names{"none", "energy", "multiplier", "stretch"};
  return names.at(std::size_t(simulation.scene.render.heatmap));
}

/// Of what decides the states, and where surfaces are in them: all that the scene says of bodies.
std::string digest_of_surfaces(const Simulation& simulation) {
  std::string bodies;
  bool is_body = false;
  std::istringstream lines(resolved_toml(simulation.scene));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("[")) is_body = line.starts_with("[body");
    if (is_body) bodies += line + "\n";
  }
  if (simulation.scene.render.surface == SurfaceKernel::smooth) bodies += "smooth";
  return sha256_hex(simulation.digest + bodies);
}

int num_states(const Simulation& simulation, const fs::path& run) {
  return std::min(count_states(run), simulation.last_frame());
}

nlohmann::json numbers(const Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Vector3d vector_of(const nlohmann::json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

/// No limit at all is infinity, which JSON does not have.
std::string motion_text(const KeptMotion& kept) {
  const HeatRange& heat = kept.motion.heat;
  nlohmann::ordered_json json;
  json["states"] = kept.states;
  json["surfaces_sha256"] = kept.surfaces;
  const ViewFit& fit = kept.motion.fit;
  json["view"] = {{"aspect", fit.aspect},
                  {"vertical_fov_degrees", fit.vertical_fov_degrees},
                  {"reach_m", {fit.right, fit.left, fit.top, fit.bottom, fit.near, fit.far}}};
  json["box_m"] = {numbers(kept.motion.box.min()), numbers(kept.motion.box.max())};
  if (kept.motion.departure > 0) json["smooth_departure_m"] = kept.motion.departure;
  json["heatmap"] = kept.heatmap;
  json["heat_largest"] = heat.largest;
  if (heat.least_limit < std::numeric_limits<double>::infinity()) json["heat_least_limit"] = heat.least_limit;
  json["heat_largest_limit"] = heat.largest_limit;
  return json.dump(2) + "\n";
}

std::optional<KeptMotion> read_motion(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  try {
    const nlohmann::json json = nlohmann::json::parse(read_file(path));
    KeptMotion kept;
    kept.states = json.at("states");
    kept.surfaces = json.at("surfaces_sha256");
    kept.heatmap = json.at("heatmap");
    kept.motion.box = Box(vector_of(json.at("box_m").at(0)), vector_of(json.at("box_m").at(1)));
    ViewFit& fit = kept.motion.fit;
    fit.aspect = json.at("view").at("aspect");
    fit.vertical_fov_degrees = json.at("view").at("vertical_fov_degrees");
    const nlohmann::json& reach = json.at("view").at("reach_m");
    int side = 0;
    for (double* number : {&fit.right, &fit.left, &fit.top, &fit.bottom, &fit.near, &fit.far})
      *number = reach.at(std::size_t(side++)).get<double>();
    kept.motion.departure = json.value("smooth_departure_m", 0.0);
    HeatRange& heat = kept.motion.heat;
    heat.largest = json.at("heat_largest");
    heat.least_limit = json.value("heat_least_limit", heat.least_limit);
    heat.largest_limit = json.at("heat_largest_limit");
    return kept;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // damaged, or of another version: it is read from the states again
  }
}

/// Widens the motion by states first .. last.
void add_states(const Simulation& simulation, const fs::path& run, int first, int last, RunMotion& motion) {
  for (int frame = first; frame <= last; ++frame) {
    const State state = read_state(state_path(run, frame), simulation.model, simulation.digest);
    for (const BodySetup& body : simulation.bodies) {
      const Points surface = surface_points(body, state.positions);
      motion.box.extend(
          Box(Vector3d(surface.colwise().minCoeff().transpose()), Vector3d(surface.colwise().maxCoeff().transpose())));
      motion.fit.extend(surface);
    }
    motion.departure = std::max(motion.departure, departure_of_surface(simulation, state.positions));
    extend(motion.heat, simulation, state);
  }
}

/// That of all states; what is kept of the first of them is not read again.
KeptMotion whole_motion(const Simulation& simulation, const fs::path& run, const std::optional<KeptMotion>& kept) {
  KeptMotion whole;
  whole.states = num_states(simulation, run);
  whole.surfaces = digest_of_surfaces(simulation);
  whole.heatmap = heatmap_name(simulation);
  const RenderDescription& render = simulation.scene.render;
  whole.motion.fit = view_fit(simulation.scene.camera, double(render.width) / render.height);
  const bool goes_on = kept && kept->motion.fit.fits(simulation.scene.camera, whole.motion.fit.aspect) &&
                       kept->states <= whole.states && kept->states > 0 && kept->surfaces == whole.surfaces &&
                       kept->heatmap == whole.heatmap;
  if (goes_on) whole.motion = kept->motion;
  add_states(simulation, run, goes_on ? kept->states + 1 : 1, whole.states, whole.motion);
  return whole;
}

}  // namespace

RunMotion motion_of_run(const Simulation& simulation, const fs::path& run) {
  return whole_motion(simulation, run, read_motion(motion_path(run))).motion;
}

void freeze_motion(const Simulation& simulation, const RunFolder& folder) {
  const fs::path file = motion_path(folder.path());
  const std::optional<KeptMotion> kept = read_motion(file);
  const std::string text = motion_text(whole_motion(simulation, folder.path(), kept));
  if (!kept || motion_text(*kept) != text) write_file(file, text);
}

}  // namespace umax
