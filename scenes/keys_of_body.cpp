// Scene keys of [body.NAME].
#include <fmt/format.h>

#include "embedding/hex_files/hex_mesh_io.h"
#include "scenes/limit_keys.h"
#include "scenes/map_keys.h"
#include "scenes/mesh_keys.h"
#include "scenes/presets.h"

namespace umax {
namespace {

constexpr int most_cells = 5000000;

// Part of the body's shape if it has that shape, else null.
template <class Shape, class T>
auto shape_part(T Shape::* member) {
  return [member](auto& body) {
    auto* shape = std::get_if<Shape>(&body.source);
    return shape ? &(shape->*member) : nullptr;
  };
}

void set_shape(const SceneValue& value, BodyDescription& body) {
  const std::string shape = WordKind{{"box", "sphere", "cylinder", "ring", "figure"}}.read(value);
  if (shape == "box") body.source = BoxShape();
  if (shape == "sphere") body.source = SphereShape();
  if (shape == "cylinder") body.source = CylinderShape();
  if (shape == "ring") body.source = RingShape();
  if (shape == "figure") body.source = FigureShape();
}

std::optional<std::string> get_shape(const BodyDescription& body) {
  constexpr const char* names[] = {"", "box", "sphere", "cylinder", "ring", "figure"};
  if (std::holds_alternative<MeshSource>(body.source)) return std::nullopt;
  return toml_string(names[body.source.index()]);
}

template <class Keys>
void add_shape_keys(Keys& keys) {
  const auto mesh_of = [](auto& body) { return std::get_if<MeshSource>(&body.source); };
  const auto become_mesh = [](const SceneValue&, BodyDescription& body) {
    if (!std::holds_alternative<MeshSource>(body.source)) body.source = MeshSource();
  };
  keys.add_custom("shape", R"("box", "sphere", "cylinder", "ring", "figure")",
                  "what it is, if no mesh: the figure is the built-in character",
                  {.group = "mesh or shape",
                   .resets = {"mesh_from", "mesh_sha256", "unit", "up", "size", "radius", "length", "thickness"},
                   .defines = true},
                  set_shape, get_shape);
  add_mesh_keys(keys, mesh_of, become_mesh,
                {.unset = "none",
                 .group = "mesh or shape",
                 .resets = {"size", "radius", "length", "thickness", "mesh_sha256"},
                 .defines = true});
  keys.add("size", VectorKind{units::length, positive_length}, shape_part(&BoxShape::size), "edges of a box",
           {.unset = VectorKind().write(BoxShape().size), .belongs_to = "shape = \"box\""});
  const auto radius = [](auto& body) {
    if (auto* sphere = std::get_if<SphereShape>(&body.source)) return &sphere->radius;
    if (auto* ring = std::get_if<RingShape>(&body.source)) return &ring->radius;
    auto* cylinder = std::get_if<CylinderShape>(&body.source);
    return cylinder ? &cylinder->radius : nullptr;
  };
  keys.add("radius", NumberKind{units::length, positive_length}, radius,
           "of a sphere or cylinder, or of the circle in the middle of a ring, around z",
           {.unset = number_text(SphereShape().radius) + ", cylinder " + number_text(CylinderShape().radius) +
                     ", ring " + number_text(RingShape().radius),
            .belongs_to = "shape = \"sphere\", \"cylinder\" or \"ring\""});
  keys.add("length", NumberKind{units::length, positive_length}, shape_part(&CylinderShape::length),
           "of a cylinder, along x",
           {.unset = number_text(CylinderShape().length), .belongs_to = "shape = \"cylinder\""});
  keys.add("thickness", NumberKind{units::length, positive_length}, shape_part(&RingShape::thickness),
           "of a ring, less than twice its radius",
           {.unset = number_text(RingShape().thickness), .belongs_to = "shape = \"ring\""});
}

template <class Keys>
void add_placement_keys(Keys& keys) {
  const std::string own_size = "as the shape is";
  keys.add("height", NumberKind{units::length, positive_length}, UMAX_FIELD(height),
           "scales the shape, rotation applied, to this height", {.unset = own_size, .group = "height or scale"});
  keys.add("scale", NumberKind{units::ratio, {.low = 0, .high = 1e9, .low_open = true}}, UMAX_FIELD(scale),
           "scales the shape", {.unset = own_size, .group = "height or scale"});
  keys.add("rotation", VectorKind{units::angle, {.low = -1e6, .high = 1e6}}, UMAX_FIELD(rotation_degrees),
           "about world X, then Y, then Z");
  keys.add("position", VectorKind{units::length, any_length}, UMAX_FIELD(position),
           "centre of the placed shape's bounding box",
           {.unset = "as the shape is", .group = "position or drop_height"});
  keys.add("drop_height", NumberKind{units::length, {.low = 0, .high = absurd_length}}, UMAX_FIELD(drop_height),
           "lowest point above the highest obstacle below", {.unset = "none", .group = "position or drop_height"});
  keys.add("velocity", VectorKind{units::speed, any_length}, UMAX_FIELD(velocity), "at the start");
  keys.add("spin", VectorKind{units::spin, any_length}, UMAX_FIELD(spin_degrees),
           "at the start, about the world's axes through the centre of mass");
}

// the hexes of the body's own file are its cage: there is none to choose
void require_no_own_hexes(const SceneValue& value, const BodyDescription& body) {
  if (body.brings_its_hexes())
    throw value_error(value,
                      "does not fit here: the hexes of " + std::get<MeshSource>(body.source).path.filename().string() +
                          " are the cage",
                      "remove it");
}

void set_cells(const SceneValue& value, BodyDescription& body) {
  require_no_own_hexes(value, body);
  const auto* array = value.as<SceneValue::Array>();
  const IntegerKind count{.low = 1, .high = most_cells};
  if (!array) {
    body.cage.size = count.read(value);
    return;
  }
  if (array->size() != 3)
    throw value_error(value, "must be a number of cells or a grid of three", "write 365 or [14, 2, 2]");
  const Vector3i grid(count.read((*array)[0]), count.read((*array)[1]), count.read((*array)[2]));
  if (double(grid[0]) * grid[1] * grid[2] > most_cells)
    throw value_error(value, "has more than 5 million cells", "give fewer cells");
  body.cage.size = grid;
}

std::optional<std::string> get_cells(const BodyDescription& body) {
  if (body.brings_its_hexes()) return std::nullopt;
  if (const int* count = std::get_if<int>(&body.cage.size)) return std::to_string(*count);
  const auto* grid = std::get_if<Vector3i>(&body.cage.size);
  if (!grid) return std::nullopt;
  return fmt::format("[{}, {}, {}]", (*grid)[0], (*grid)[1], (*grid)[2]);
}

void set_cage_mesh(const SceneValue& value, BodyDescription& body) {
  require_no_own_hexes(value, body);
  MeshSource cage;
  read_mesh_path(value, cage);
  if (!is_hex_mesh_file(cage.path))
    throw value_error(value, "is no mesh of hexes by its name", "give a .msh, .vtk or .vtu file");
  body.cage.size = cage;
}

template <class Keys>
void add_cage_mesh_keys(Keys& keys, const std::string& group) {
  const auto file_of = [](const BodyDescription& body) { return std::get_if<MeshSource>(&body.cage.size); };
  keys.add_custom("cage.mesh", PathKind().type(),
                  "file of the hexes that hold the surface: .msh, .vtk, .vtu; in its units and axes, placed along",
                  {.unset = "none", .group = group, .resets = {"cage.clip", "cage.mesh_sha256"}}, set_cage_mesh,
                  [file_of](const BodyDescription& body) -> std::optional<std::string> {
                    const MeshSource* file = file_of(body);
                    return file ? std::optional(PathKind().write(file->path)) : std::nullopt;
                  });
  keys.add_custom(
      "cage.mesh_sha256", "text", "SHA-256 of the file of hexes; another file is refused", {.unset = "not checked"},
      [file_of](const SceneValue& value, BodyDescription& body) {
        const MeshSource* file = file_of(body);
        if (!file) throw value_error(value, "does not fit here", "it belongs to cage.mesh = \"PATH\"");
        check_mesh_sha256(value, *file);
      },
      [file_of](const BodyDescription& body) -> std::optional<std::string> {
        const MeshSource* file = file_of(body);
        return file ? std::optional(toml_string(file->sha256)) : std::nullopt;
      });
}

template <class Keys>
void add_cage_keys(Keys& keys) {
  const std::string group = "cage.cells, cage.cell_size or cage.mesh";
  keys.add_custom("cage.cells", "integer, 1 … 5000000, or [nx, ny, nz]",
                  "wanted number of hexes (the nearest possible is taken), or the grid over the bounding box",
                  {.group = group}, set_cells, get_cells);
  const NumberKind edge{units::length, positive_length};
  keys.add_custom(
      "cage.cell_size", edge.type(), "edge of a hex", {.unset = "from cage.cells", .group = group},
      [edge](const SceneValue& value, BodyDescription& body) {
        require_no_own_hexes(value, body);
        body.cage.size = edge.read(value);
      },
      [edge](const BodyDescription& body) -> std::optional<std::string> {
        const double* size = std::get_if<double>(&body.cage.size);
        return size ? std::optional(edge.write(*size)) : std::nullopt;
      });
  add_cage_mesh_keys(keys, group);
  using Clip = CageDescription::Clip;
  const auto clip = [](auto& body) {
    const bool has_cells = !body.brings_its_hexes() && !std::holds_alternative<MeshSource>(body.cage.size);
    return has_cells ? &body.cage.clip : nullptr;
  };
  keys.add("cage.clip", ChoiceKind<Clip>{{{"filled", Clip::filled}, {"box", Clip::box}}}, clip,
           "filled: hexes that touch the solid; box: the whole grid",
           {.belongs_to = "cage.cells and cage.cell_size; the hexes of a file are the whole cage"});
}

// presets are expanded before keys are read (scenes/presets.h), and a resolved scene has their values
template <class Keys>
void add_preset_key(Keys& keys) {
  keys.add_custom(
      "material.preset", TextKind().type(),
      "a material by name (umax presets): gives the material and limit keys that are not given here, and how light "
      "gets "
      "into it",
      {.unset = "none"}, [](const SceneValue& value, BodyDescription&) { TextKind().read(value); },
      [](const BodyDescription&) { return std::optional<std::string>(); });
}

// A --set of the preset drops the file's material and limit, but for what is painted or weighed.
void let_preset_reset(SceneSection& section) {
  std::vector<std::string> replaced;
  for (const SceneKey& key : section.keys) {
    const bool stays = key.name == "material.mass" || key.name.find("map") != std::string::npos;
    if (is_preset_key(key.name) && !stays) replaced.push_back(key.name);
  }
  for (SceneKey& key : section.keys)
    if (key.name == "material.preset") key.resets = replaced;
}

template <class Keys>
void add_material_keys(Keys& keys) {
  keys.add("material.young", TrackKind<NumberKind>{{units::pressure, {.low = 0, .high = 1e15, .low_open = true}}},
           UMAX_FIELD(material.young), "Young's modulus");
  add_factor_map_keys(keys, "material.young_map", UMAX_FIELD(young_map), "Young's modulus");
  keys.add("material.poisson", NumberKind{units::ratio, {.low = -1, .high = 0.5, .low_open = true, .high_open = true}},
           UMAX_FIELD(material.poisson), "Poisson's ratio");
  keys.add("material.density", TrackKind<NumberKind>{{units::density, {.low = 0, .high = 1e9, .low_open = true}}},
           UMAX_FIELD(material.density), "mass per volume");
  keys.add("material.mass", ChoiceKind<MassModel>{{{"mesh", MassModel::mesh}, {"lattice", MassModel::lattice}}},
           UMAX_FIELD(material.mass), "mesh: a hex weighs its filled fraction, at least 5 %; lattice: full hexes");
  keys.add("material.damping_mass", TrackKind<NumberKind>{{units::rate, not_negative}},
           UMAX_FIELD(material.damping_mass), "Rayleigh damping by mass: slows all motion");
  keys.add("material.damping_stiffness", TrackKind<NumberKind>{{units::time, not_negative}},
           UMAX_FIELD(material.damping_stiffness), "Rayleigh damping by stiffness: slows deformation");
}

void read_fixed(const SceneValue& value, BodyDescription& body) {
  const std::string remedy = "write [{ min = [x, y, z], max = [x, y, z] }]";
  const auto* boxes = value.as<SceneValue::Array>();
  if (!boxes) throw value_error(value, "must be a list of boxes, but is " + type_text(value), remedy);
  body.fixed.clear();
  for (const SceneValue& entry : *boxes) {
    const auto* table = entry.as<SceneValue::Table>();
    if (!table || table->size() != 2) throw value_error(entry, "must be a box with min and max", remedy);
    FixedBox box;
    for (const auto& [name, corner] : *table) {
      if (name != "min" && name != "max")
        throw value_error(corner, "has the unknown part " + toml_string(name), remedy);
      (name == "min" ? box.min : box.max) = VectorKind{units::length, any_number}.read(corner);
    }
    if ((box.min.array() > box.max.array()).any()) throw value_error(entry, "has a min beyond its max", "swap them");
    body.fixed.push_back(box);
  }
}

std::optional<std::string> get_fixed(const BodyDescription& body) {
  std::string text = "[";
  for (const FixedBox& box : body.fixed)
    text += (text.size() > 1 ? ", { min = " : "{ min = ") + VectorKind().write(box.min) +
            ", max = " + VectorKind().write(box.max) + " }";
  return text + "]";
}

}  // namespace

bool BodyDescription::brings_its_hexes() const {
  const auto* mesh = std::get_if<MeshSource>(&source);
  return mesh && is_hex_mesh_file(mesh->path);
}

SceneSection body_section() {
  SceneSection section{.name = "body", .meaning = "a soft body"};
  auto keys = named_section(section, &Scene::bodies);
  add_shape_keys(keys);
  add_placement_keys(keys);
  keys.add("friction", TrackKind<NumberKind>{{units::ratio, {.low = 0, .high = 1000}}}, UMAX_FIELD(friction),
           "Coulomb coefficient; of two that touch the larger one counts");
  keys.add("contact",
           ChoiceKind<ContactWith>{{{"all", ContactWith::all},
                                    {"others", ContactWith::others},
                                    {"obstacles", ContactWith::obstacles},
                                    {"none", ContactWith::none}}},
           UMAX_FIELD(contact),
           "what it touches: everything that allows it, itself too; all but itself; obstacles alone; nothing");
  add_cage_keys(keys);
  add_preset_key(keys);
  add_material_keys(keys);
  add_all_limit_keys(keys);
  keys.add_custom("fixed", "list of { min = [x, y, z], max = [x, y, z] } [m]",
                  "nodes in these boxes stay put; world coordinates of the initial placed shape", {}, read_fixed,
                  get_fixed);
  add_look_keys(keys);
  const auto texture = [](auto& body) { return body.texture_path.empty() ? nullptr : &body.texture_path; };
  keys.add_custom(
      "look.texture", "path", "picture that multiplies the colour, where the mesh has texture coordinates",
      {.unset = "the mesh file's own"},
      [](const SceneValue& value, BodyDescription& body) { body.texture_path = ExistingFileKind().read(value); },
      [texture](const BodyDescription& body) -> std::optional<std::string> {
        return texture(body) ? std::optional(PathKind().write(body.texture_path)) : std::nullopt;
      });
  let_preset_reset(section);
  return section;
}

}  // namespace umax
