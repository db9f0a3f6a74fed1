// Scene keys of [obstacle.NAME], [pair.NAME] and [probe.NAME].
#include "scenes/cache_keys.h"
#include "scenes/mesh_keys.h"

namespace umax {
namespace {

void set_shape(const SceneValue& value, ObstacleDescription& obstacle) {
  const std::string shape = WordKind{{"plane", "sphere", "box", "bowl", "mesh"}}.read(value);
  if (shape == "plane") obstacle.shape = HalfSpace();
  if (shape == "sphere") obstacle.shape = Ball();
  if (shape == "box") obstacle.shape = Block();
  if (shape == "bowl") obstacle.shape = BowlShape();
  if (shape == "mesh") obstacle.shape = MeshSource();
}

std::optional<std::string> get_shape(const ObstacleDescription& obstacle) {
  constexpr const char* names[] = {"plane", "sphere", "box", "bowl", "mesh"};
  return toml_string(names[obstacle.shape.index()]);
}

void set_size(const SceneValue& value, ObstacleDescription& obstacle) {
  auto* block = std::get_if<Block>(&obstacle.shape);
  if (!block) throw value_error(value, "does not fit here", "it belongs to shape = \"box\"");
  block->half_size = VectorKind{units::length, positive_length}.read(value) / 2;
}

std::optional<std::string> get_size(const ObstacleDescription& obstacle) {
  const auto* block = std::get_if<Block>(&obstacle.shape);
  return block ? std::optional(VectorKind().write(2 * block->half_size)) : std::nullopt;
}

void set_thickness(const SceneValue& value, ObstacleDescription& obstacle) {
  const NumberKind kind{units::length, positive_length};
  if (auto* bowl = std::get_if<BowlShape>(&obstacle.shape))
    bowl->thickness = kind.read(value);
  else if (!obstacle.cache.path.empty())
    obstacle.thickness = kind.read(value);
  else
    throw value_error(value, "does not fit here", "it belongs to shape = \"bowl\", or to a mesh with a cache");
}

std::optional<std::string> get_thickness(const ObstacleDescription& obstacle) {
  const auto* bowl = std::get_if<BowlShape>(&obstacle.shape);
  if (!bowl && !obstacle.thickness) return std::nullopt;
  return number_text(bowl ? bowl->thickness : *obstacle.thickness);
}

template <class Keys>
void add_shape_keys(Keys& keys) {
  const std::string of_mesh = "shape = \"mesh\"";
  const auto mesh_of = [](auto& obstacle) { return std::get_if<MeshSource>(&obstacle.shape); };
  const auto require_mesh = [of_mesh](const SceneValue& value, ObstacleDescription& obstacle) {
    if (!std::holds_alternative<MeshSource>(obstacle.shape))
      throw value_error(value, "does not fit here", "it belongs to " + of_mesh);
  };
  keys.add_custom(
      "shape", R"("plane", "sphere", "box", "bowl", "mesh")", "what it is; a plane is solid below its y = 0",
      {.unset = "required",
       .resets = {"mesh", "mesh_from", "mesh_sha256", "unit", "up", "height", "scale", "size", "radius", "thickness",
                  "cache", "cache_start", "cache_speed", "cache_offset", "cache_fps", "cache_sha256", "fade"},
       .defines = true,
       .required = true},
      set_shape, get_shape);
  add_mesh_keys(keys, mesh_of, require_mesh, {.unset = "none", .resets = {"mesh_sha256"}});
  keys.add_custom("size", VectorKind{units::length, positive_length}.type(), "edges of a box",
                  {.unset = VectorKind().write(2 * Block().half_size)}, set_size, get_size);
  const auto radius = [](auto& obstacle) {
    auto* ball = std::get_if<Ball>(&obstacle.shape);
    auto* bowl = std::get_if<BowlShape>(&obstacle.shape);
    return ball ? &ball->radius : bowl ? &bowl->radius : nullptr;
  };
  keys.add("radius", NumberKind{units::length, positive_length}, radius, "of a sphere, or of a bowl's rim",
           {.unset = number_text(Ball().radius), .belongs_to = "shape = \"sphere\" or \"bowl\""});
  const auto require_mesh_here = [mesh_of, of_mesh](const SceneValue& value, const ObstacleDescription& obstacle) {
    if (!mesh_of(obstacle)) throw value_error(value, "does not fit here", "it belongs to " + of_mesh);
  };
  add_cache_keys(keys, "cache",
                 "animation of the mesh's vertices: .pc2, .mdd, or a folder of OBJ or PLY files, one a frame; in the "
                 "order, units and axes of the mesh",
                 UMAX_FIELD(cache), require_mesh_here);
  keys.add_custom("thickness", NumberKind{units::length, positive_length}.type(),
                  "of a bowl; of an animated mesh: half of it lies on each side of the surface",
                  {.unset = number_text(BowlShape().thickness) +
                            "; animated: 0 where the mesh is closed, else a hundredth of its size"},
                  set_thickness, get_thickness);
  const auto of_mesh_only = [mesh_of](auto member) {
    return [mesh_of, member](auto& obstacle) { return mesh_of(obstacle) ? &(obstacle.*member) : nullptr; };
  };
  keys.add("height", NumberKind{units::length, positive_length}, of_mesh_only(&ObstacleDescription::height),
           "scales a mesh to this height",
           {.unset = "as the mesh is", .belongs_to = of_mesh, .group = "height or scale"});
  keys.add("scale", NumberKind{units::ratio, positive_length}, of_mesh_only(&ObstacleDescription::scale),
           "scales a mesh", {.unset = "as the mesh is", .belongs_to = of_mesh, .group = "height or scale"});
}

void set_pair(const SceneValue& value, PairDescription& pair) {
  const std::string remedy = "write [\"A\", \"B\"], or [\"A\", \"A\"] for a body and itself";
  const auto* names = value.as<SceneValue::Array>();
  if (!names) throw value_error(value, "must be a list of two bodies, but is " + type_text(value), remedy);
  if (names->size() != 2)
    throw value_error(value, "must have two bodies, but has " + std::to_string(names->size()), remedy);
  for (std::size_t i = 0; i < 2; ++i) pair.bodies[i] = TextKind().read((*names)[i]);
}

std::optional<std::string> get_pair(const PairDescription& pair) {
  return "[" + toml_string(pair.bodies[0]) + ", " + toml_string(pair.bodies[1]) + "]";
}

}  // namespace

SceneSection obstacle_section() {
  SceneSection section{.name = "obstacle", .meaning = "something that bodies fall on, at rest or moving by keyframes"};
  auto keys = named_section(section, &Scene::obstacles);
  add_shape_keys(keys);
  keys.add("friction", NumberKind{units::ratio, {.low = 0, .high = 1000}}, UMAX_FIELD(friction),
           "Coulomb coefficient; of two that touch the larger one counts");
  keys.add("position", TrackKind<VectorKind>{{units::length, any_length}}, UMAX_FIELD(position),
           "of the centre of a sphere or box, of a bowl's bottom, a plane's or mesh's own origin");
  keys.add("rotation", TrackKind<VectorKind>{{units::angle, {.low = -1e6, .high = 1e6}}}, UMAX_FIELD(rotation_degrees),
           "about world X, then Y, then Z");
  keys.add("visible", FlagKind(), UMAX_FIELD(visible), "whether pictures show it");
  keys.add("shadow_catcher", FlagKind(), UMAX_FIELD(shadow_catcher),
           "pictures show the shadows that fall on it, and what is behind it (embree)");
  const auto of_plane = [](auto& obstacle) {
    return std::holds_alternative<HalfSpace>(obstacle.shape) ? &obstacle.fade : nullptr;
  };
  keys.add("fade", NumberKind{units::length, positive_length}, of_plane,
           "distance from its position at which a plane has passed into what is behind it at the horizon, as a "
           "studio's sweep does",
           {.unset = "it ends far away", .belongs_to = "shape = \"plane\""});
  add_look_keys(keys);
  return section;
}

SceneSection pair_section() {
  SceneSection section{.name = "pair", .meaning = "an exception for two bodies, or for a body and itself"};
  auto keys = named_section(section, &Scene::pairs);
  keys.add_custom("bodies", "list of two names", "the two bodies; the same name twice: the body and itself",
                  {.unset = "required", .defines = true, .required = true}, set_pair, get_pair);
  keys.add("touch", FlagKind(), UMAX_FIELD(touch), "whether they touch, whatever their contact says");
  keys.add("friction", NumberKind{units::ratio, {.low = 0, .high = 1000}}, UMAX_FIELD(friction),
           "Coulomb coefficient between them", {.unset = "the larger of the two"});
  return section;
}

SceneSection probe_section() {
  SceneSection section{.name = "probe", .meaning = "a material point whose position goes into steps.csv"};
  auto keys = named_section(section, &Scene::probes);
  keys.add("body", TextKind(), UMAX_FIELD(body), "name of the body that it rides on", {.unset = "the only body"});
  keys.add("point", VectorKind{units::length, any_length}, UMAX_FIELD(point),
           "in world coordinates of the initial placed shape",
           {.unset = "required", .defines = true, .required = true});
  return section;
}

}  // namespace umax
