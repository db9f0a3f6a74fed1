// Scene keys of [body.NAME.pin.PIN].
#include "scenes/cache_keys.h"
#include "scenes/mesh_keys.h"

namespace umax {
namespace {

const std::string region = "box, sphere, map or inside";

using Text = std::optional<std::string>;

// { first = …, second = … }: calls read(name, value) for each of the two
template <class Read>
void read_parts(const SceneValue& value, const std::string& first, const std::string& second, const std::string& remedy,
                const Read& read) {
  const auto* table = value.as<SceneValue::Table>();
  if (!table || table->size() != 2) throw value_error(value, "must have " + first + " and " + second, remedy);
  for (const auto& [name, part] : *table) {
    if (name != first && name != second) throw value_error(part, "has the unknown part " + toml_string(name), remedy);
    read(name, part);
  }
}

void read_box(const SceneValue& value, PinDescription& pin) {
  read_parts(value, "min", "max", "write { min = [x, y, z], max = [x, y, z] }",
             [&](const std::string& name, const SceneValue& part) {
               (name == "min" ? pin.box.min : pin.box.max) = VectorKind{units::length, any_length}.read(part);
             });
  if ((pin.box.min->array() > pin.box.max->array()).any())
    throw value_error(value, "has a min beyond its max", "swap them");
}

Text write_box(const PinDescription& pin) {
  if (!pin.box.min) return std::nullopt;
  return "{ min = " + VectorKind().write(*pin.box.min) + ", max = " + VectorKind().write(*pin.box.max) + " }";
}

void read_sphere(const SceneValue& value, PinDescription& pin) {
  read_parts(value, "centre", "radius", "write { centre = [x, y, z], radius = \"10 cm\" }",
             [&](const std::string& name, const SceneValue& part) {
               if (name == "centre")
                 pin.sphere.centre = VectorKind{units::length, any_length}.read(part);
               else
                 pin.sphere.radius = NumberKind{units::length, positive_length}.read(part);
             });
}

Text write_sphere(const PinDescription& pin) {
  if (!pin.sphere.centre) return std::nullopt;
  return "{ centre = " + VectorKind().write(*pin.sphere.centre) + ", radius = " + number_text(*pin.sphere.radius) +
         " }";
}

template <class Keys>
void add_region_keys(Keys& keys) {
  keys.add_custom("box", "{ min = [x, y, z], max = [x, y, z] } [m]",
                  "the points of the body's surface in this box, world coordinates of the initial placed shape",
                  {.unset = "none", .group = region}, read_box, write_box);
  keys.add_custom("sphere", "{ centre = [x, y, z], radius = number } [m]", "those in this sphere, likewise",
                  {.unset = "none", .group = region}, read_sphere, write_sphere);
  keys.add_custom(
      "map", "path",
      "painted copy of the body's mesh: black points are free, white ones exact, between them a spring pulls",
      {.unset = "none", .group = region, .resets = {"map_sha256"}},
      [](const SceneValue& value, PinDescription& pin) {
        pin.map = ExistingFileKind().read(value);
        pin.map_sha256 = sha256_of_file(pin.map);
      },
      [](const PinDescription& pin) -> Text {
        return pin.map.empty() ? std::nullopt : Text(PathKind().write(pin.map));
      });
  keys.add_custom(
      "map_sha256", "text", "SHA-256 of the painted mesh; another file is refused", {.unset = "not checked"},
      [](const SceneValue& value, PinDescription& pin) {
        if (pin.map.empty()) throw value_error(value, "does not fit here", "it belongs to map = \"PATH\"");
        check_sha256(value, "map", pin.map, pin.map_sha256);
      },
      [](const PinDescription& pin) -> Text {
        return pin.map.empty() ? std::nullopt : Text(toml_string(pin.map_sha256));
      });
  keys.add_custom(
      "inside", "path", "mesh of bones: what of the body is inside of it, in the units and axes of the body's mesh",
      {.unset = "none", .group = region, .resets = {"inside_sha256"}},
      [](const SceneValue& value, PinDescription& pin) { read_mesh_path(value, pin.inside); },
      [](const PinDescription& pin) -> Text {
        return pin.inside.path.empty() ? std::nullopt : Text(PathKind().write(pin.inside.path));
      });
  keys.add_custom(
      "inside_sha256", "text", "SHA-256 of that mesh; another file is refused", {.unset = "not checked"},
      [](const SceneValue& value, PinDescription& pin) {
        if (pin.inside.path.empty()) throw value_error(value, "does not fit here", "it belongs to inside = \"PATH\"");
        check_mesh_sha256(value, pin.inside);
      },
      [](const PinDescription& pin) -> Text {
        return pin.inside.path.empty() ? std::nullopt : Text(toml_string(pin.inside.sha256));
      });
}

template <class Keys>
void add_follow_keys(Keys& keys) {
  keys.add("follow.position", TrackKind<VectorKind>{{units::length, any_length}}, UMAX_FIELD(position),
           "by how much the points are moved from where they are at rest", {.unset = "not moved"});
  keys.add("follow.rotation", TrackKind<VectorKind>{{units::angle, {.low = -1e6, .high = 1e6}}},
           UMAX_FIELD(rotation_degrees), "by how much they are turned about the pivot: world X, then Y, then Z",
           {.unset = "not turned"});
  keys.add("follow.pivot", VectorKind{units::length, any_length}, UMAX_FIELD(pivot), "what they are turned about",
           {.unset = "the middle of the points' box"});
  add_cache_keys(
      keys, "follow.cache",
      "animation that they follow instead, of the mesh in `inside`, else of the body's own: .pc2, .mdd, or a "
      "folder of OBJ or PLY files, one a frame",
      UMAX_FIELD(cache), [](const SceneValue& value, const PinDescription& pin) {
        if (pin.position || pin.rotation_degrees)
          throw value_error(value, "does not fit beside follow.position and follow.rotation",
                            "give keyframes or an animation");
      });
}

}  // namespace

SceneSection pin_section() {
  SceneSection section{.name = "pin",
                       .within = "body",
                       .meaning = "points of the body that go where they are told, or stay where they are"};
  auto keys = named_section(section, &Scene::pins);
  section.add = [](Scene& scene, const std::string& name) {
    const std::size_t dot = name.find('.');
    PinDescription& pin = scene.pins.emplace_back();
    pin.body = name.substr(0, dot), pin.name = name.substr(dot + 1);
    return scene.pins.size() - 1;
  };
  section.names = [](const Scene& scene) {
    std::vector<std::string> names;
    for (const PinDescription& pin : scene.pins) names.push_back(pin.body + "." + pin.name);
    return names;
  };
  add_region_keys(keys);
  add_follow_keys(keys);
  keys.add("from", NumberKind{units::time, any_number}, UMAX_FIELD(from), "when it begins to hold",
           {.unset = "the beginning"});
  keys.add("until", NumberKind{units::time, any_number}, UMAX_FIELD(until), "when it lets go", {.unset = "the end"});
  keys.add("stiffness", NumberKind{units::stiffness, {.low = 0, .high = 1e15, .low_open = true}}, UMAX_FIELD(stiffness),
           "of a spring that pulls each point, in place of holding it exactly",
           {.unset = "exact; of a point half way between black and white: its share of the hex's own"});
  return section;
}

}  // namespace umax
