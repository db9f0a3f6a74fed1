#include "scenes/scene_checks.h"

#include <algorithm>
#include <map>

#include "core/base/nearest_word.h"
#include "scenes/quantity.h"

namespace umax {
namespace {

std::vector<std::string> body_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const BodyDescription& body : scene.bodies) names.push_back(body.name);
  return names;
}

// Place of a key if it is given, else of its thing's table.
std::string where(const SceneDocument& document, const std::string& section, const std::string& thing,
                  const std::string& key) {
  const DocumentThing& entry = document.at(section).at(thing);
  const auto value = entry.values.find(key);
  const SourcePlace& place = value != entry.values.end() ? value->second.place : entry.place;
  return where_text(place, find_section(section)->key_prefix(thing) + key);
}

void check_mesh(const MeshSource& mesh, const std::string& place, const std::string& key) {
  if (!mesh.path.empty()) return;
  if (mesh.from.empty())
    throw Error(Fault::bad_data, {.where = place, .what = "is missing", .remedy = "give the path of a mesh file"});
  throw Error(Fault::not_found,
              {.where = place,
               .what = "this scene needs a mesh that is not part of the program",
               .remedy = "it is had from " + mesh.from + "; then give its path: --set " + key + "=PATH"});
}

void check_meshes(const Scene& scene, const SceneDocument& document) {
  for (const BodyDescription& body : scene.bodies)
    if (const auto* mesh = std::get_if<MeshSource>(&body.source))
      check_mesh(*mesh, where(document, "body", body.name, "mesh"), "body." + body.name + ".mesh");
  for (const ObstacleDescription& obstacle : scene.obstacles)
    if (const auto* mesh = std::get_if<MeshSource>(&obstacle.shape))
      check_mesh(*mesh, where(document, "obstacle", obstacle.name, "mesh"), "obstacle." + obstacle.name + ".mesh");
}

Error no_such_body(const std::string& place, const std::string& name, const std::vector<std::string>& names) {
  return Error(Fault::bad_data, {.where = place,
                                 .what = "there is no such body",
                                 .value = toml_string(name),
                                 .remedy = "did you mean \"" + nearest_word(name, names) + "\"?"});
}

void check_pairs(const Scene& scene, const SceneDocument& document) {
  const std::vector<std::string> names = body_names(scene);
  std::map<std::array<std::string, 2>, std::string> seen;
  for (const PairDescription& pair : scene.pairs) {
    const std::string place = where(document, "pair", pair.name, "bodies");
    for (const std::string& name : pair.bodies)
      if (std::find(names.begin(), names.end(), name) == names.end()) throw no_such_body(place, name, names);
    std::array<std::string, 2> sorted = pair.bodies;
    std::sort(sorted.begin(), sorted.end());
    const auto [first, is_first] = seen.try_emplace(sorted, pair.name);
    if (!is_first)
      throw Error(Fault::bad_data,
                  {.where = place,
                   .what = "are the bodies of [pair." + first->second + "], too",
                   .value = "[" + toml_string(pair.bodies[0]) + ", " + toml_string(pair.bodies[1]) + "]",
                   .remedy = "remove one of the two pairs"});
  }
}

void check_pins(const Scene& scene, const SceneDocument& document) {
  for (const PinDescription& pin : scene.pins) {
    const std::string name = pin.body + "." + pin.name;
    if (!pin.box.min && !pin.sphere.centre && pin.map.empty() && pin.inside.path.empty())
      throw Error(Fault::bad_data, {.where = where(document, "pin", name, "box"),
                                    .what = "is missing: the pin does not say what it holds",
                                    .remedy = "give one of box, sphere, map and inside"});
    if (pin.from && pin.until && *pin.from >= *pin.until)
      throw Error(Fault::bad_data, {.where = where(document, "pin", name, "until"),
                                    .what = "is no later than from",
                                    .value = number_text(*pin.until) + " s",
                                    .remedy = "give a later time, or leave it out"});
    if (scene.solver.method == SolverMethod::paper)
      throw Error(Fault::bad_data, {.where = where(document, "solver", "", "method"),
                                    .what = "is the paper's, which knows no pins",
                                    .value = "\"paper\"",
                                    .remedy = "leave it out, or remove body." + pin.body + ".pin"});
  }
}

void complete_probes(Scene& scene, const SceneDocument& document) {
  const std::vector<std::string> names = body_names(scene);
  for (ProbeDescription& probe : scene.probes) {
    if (probe.body.empty() && names.size() == 1) probe.body = names.front();
    if (std::find(names.begin(), names.end(), probe.body) != names.end()) continue;
    const std::string place = where(document, "probe", probe.name, "body");
    if (probe.body.empty())
      throw Error(Fault::bad_data,
                  {.where = place, .what = "is missing", .remedy = "name one of the bodies " + list_text(names)});
    throw no_such_body(place, probe.body, names);
  }
}

/// The rasteriser draws pictures only.
void check_engine(const Scene& scene, const SceneDocument& document) {
  const RenderDescription& render = scene.render;
  if (render.engine == RenderEngine::embree) return;
  const auto fail = [&](const std::string& key, const std::string& remedy) {
    throw Error(Fault::bad_data, {.where = where(document, "render", "", key),
                                  .what = "is more than the rasteriser can draw",
                                  .remedy = "use --engine embree, or " + remedy});
  };
  if (!render.layers.empty()) fail("layers", "--set render.layers=[]");
  if (render.transparent) fail("transparent", "--set render.transparent=false");
  for (const ObstacleDescription& obstacle : scene.obstacles)
    if (obstacle.shadow_catcher && obstacle.visible)
      throw Error(Fault::bad_data,
                  {.where = where(document, "obstacle", obstacle.name, "shadow_catcher"),
                   .what = "is more than the rasteriser can draw",
                   .remedy = "use --engine embree, or --set obstacle." + obstacle.name + ".shadow_catcher=false"});
}

bool meet_at_a_key(const Track<Vector3d>& a, const Track<Vector3d>& b) {
  const auto meet = [&](double time) { return a.at(time) == b.at(time); };
  return std::any_of(a.times.begin(), a.times.end(), meet) || std::any_of(b.times.begin(), b.times.end(), meet);
}

void check_views(const Scene& scene, const SceneDocument& document) {
  for (const LightDescription& light : scene.lights)
    if (meet_at_a_key(light.position, light.target))
      throw Error(Fault::bad_data, {.where = where(document, "light", light.name, "position"),
                                    .what = "is also the light's target",
                                    .remedy = "move one of them"});
  if (!scene.camera.file.empty() && (scene.camera.position || scene.camera.target))
    throw Error(Fault::bad_data, {.where = where(document, "camera", "", "file"),
                                  .what = "brings its own place and direction",
                                  .remedy = "remove camera.position and camera.target"});
  if (scene.camera.position && scene.camera.target && meet_at_a_key(*scene.camera.position, *scene.camera.target))
    throw Error(Fault::bad_data, {.where = where(document, "camera", "", "position"),
                                  .what = "is also the camera's target",
                                  .remedy = "move one of them"});
  if (std::holds_alternative<EnvironmentMap>(scene.render.sky) && scene.render.sky_path.empty())
    throw Error(Fault::bad_data, {.where = where(document, "render", "", "sky.map"),
                                  .what = "is missing",
                                  .remedy = "give the path of an HDR or EXR picture"});
}

}  // namespace

void complete_and_check(Scene& scene, const SceneDocument& document) {
  if (scene.bodies.empty())
    throw Error(Fault::bad_data, {.where = document.at("").at("").place.file,
                                  .what = "the scene has no body",
                                  .remedy = "add one: [body.NAME] with mesh = \"PATH\" or shape = \"sphere\""});
  check_meshes(scene, document);
  check_pairs(scene, document);
  check_pins(scene, document);
  complete_probes(scene, document);
  check_views(scene, document);
  check_engine(scene, document);
}

}  // namespace umax
