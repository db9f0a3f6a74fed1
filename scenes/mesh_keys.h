// Scene keys that bodies and obstacles share: where a mesh comes from, and how a surface looks.
#pragma once

#include "core/files/sha256.h"
#include "scenes/section_builder.h"

namespace umax {

/// Reads the path of a mesh; the file must be there. Fills path and sha256.
inline void read_mesh_path(const SceneValue& value, MeshSource& mesh) {
  mesh.path = PathKind().read(value);
  std::error_code failed;
  if (!std::filesystem::is_regular_file(mesh.path, failed)) {
    throw Error(Fault::not_found, {.where = where_text(value.place, value.key),
                                   .what = "no such file",
                                   .value = mesh.path.string(),
                                   .remedy = mesh.from.empty() ? "check the path" : "it is had from " + mesh.from});
  }
  mesh.sha256 = sha256_of_file(mesh.path);
}

/// Reads the SHA-256 that a file must have, "mesh" or "map", and compares it with what the file has.
inline void check_sha256(const SceneValue& value, const std::string& thing, const std::filesystem::path& path,
                         const std::string& sha256) {
  const std::string wanted = TextKind().read(value);
  if (wanted == sha256) return;
  throw value_error(
      value,
      "the " + thing + " " + path.string() + " is not the one that the scene was made with: its SHA-256 is " + sha256,
      "restore the " + thing + ", or remove this key to accept the new one");
}
inline void check_mesh_sha256(const SceneValue& value, const MeshSource& mesh) {
  check_sha256(value, "mesh", mesh.path, mesh.sha256);
}

/// mesh_of(thing): a pointer to its MeshSource, null while it has another shape. become_mesh(value, thing): makes it a
/// mesh, or throws where another shape was asked for.
template <class Builder, class MeshOf, class BecomeMesh>
void add_mesh_keys(Builder& keys, const MeshOf& mesh_of, const BecomeMesh& become_mesh, const KeyTraits& traits) {
  const auto set_from = [mesh_of, become_mesh](const SceneValue& value, auto& thing) {
    become_mesh(value, thing);
    mesh_of(thing)->from = TextKind().read(value);
  };
  const auto get_from = [mesh_of](const auto& thing) -> std::optional<std::string> {
    const auto* mesh = mesh_of(thing);
    return mesh ? std::optional(toml_string(mesh->from)) : std::nullopt;
  };
  keys.add_custom("mesh_from", "text", "where the mesh is had: said when it is missing", {.unset = "\"\""}, set_from,
                  get_from);

  const auto set_path = [mesh_of, become_mesh](const SceneValue& value, auto& thing) {
    become_mesh(value, thing);
    read_mesh_path(value, *mesh_of(thing));
  };
  const auto get_path = [mesh_of](const auto& thing) -> std::optional<std::string> {
    const auto* mesh = mesh_of(thing);
    return mesh ? std::optional(PathKind().write(mesh->path)) : std::nullopt;
  };
  keys.add_custom("mesh", "path",
                  "file of the surface: OBJ, PLY, STL, OFF, glTF, FBX, COLLADA; or of hexes: Gmsh .msh, VTK .vtk, .vtu",
                  traits, set_path, get_path);

  const auto set_hash = [mesh_of](const SceneValue& value, auto& thing) {
    const auto* mesh = mesh_of(thing);
    if (!mesh || mesh->path.empty()) throw value_error(value, "does not fit here", "it belongs to mesh = \"PATH\"");
    check_mesh_sha256(value, *mesh);
  };
  const auto get_hash = [mesh_of](const auto& thing) -> std::optional<std::string> {
    const auto* mesh = mesh_of(thing);
    return mesh ? std::optional(toml_string(mesh->sha256)) : std::nullopt;
  };
  keys.add_custom("mesh_sha256", "text", "SHA-256 of the mesh file; another file is refused", {.unset = "not checked"},
                  set_hash, get_hash);

  const auto part = [mesh_of](auto member) {
    return [mesh_of, member](auto& thing) {
      auto* mesh = mesh_of(thing);
      return mesh ? &(mesh->*member) : nullptr;
    };
  };
  keys.add("unit", LengthUnitKind(), part(&MeshSource::unit), "length of one unit of the mesh file",
           {.unset = "the file's own, else m", .belongs_to = "a mesh"});
  keys.add("up", WordKind{{"x", "y", "z", "-x", "-y", "-z"}}, part(&MeshSource::up),
           "the mesh file's axis that points up", {.unset = "the file's own, else \"y\"", .belongs_to = "a mesh"});
}

/// Keys of the field `look`.
template <class Builder>
void add_look_keys(Builder& keys) {
  const NumberKind fraction{units::ratio, zero_to_one};
  keys.add("look.color", ColorKind(), UMAX_FIELD(look.base_color), "colour of the surface");
  keys.add("look.roughness", fraction, UMAX_FIELD(look.roughness), "0: mirror-like, 1: matt");
  keys.add("look.ior", NumberKind{units::ratio, {.low = 1, .high = 4}}, UMAX_FIELD(look.ior),
           "refractive index of the glossy layer: strength of reflections");
  keys.add("look.metallic", fraction, UMAX_FIELD(look.metallic), "0: plastic-like, 1: metal");
  keys.add("look.clearcoat", fraction, UMAX_FIELD(look.clearcoat), "strength of a coat of varnish");
  keys.add("look.clearcoat_roughness", fraction, UMAX_FIELD(look.clearcoat_roughness), "roughness of the varnish");
  keys.add("look.transmission", fraction, UMAX_FIELD(look.transmission),
           "share of the base that is clear, as of glass or gel: light passes, bent by look.ior, blurred by "
           "look.roughness; closed surfaces only");
  keys.add("look.transmission_depth", NumberKind{units::length, positive_length}, UMAX_FIELD(look.transmission_depth),
           "how far light goes in clear matter until it has look.color");
  keys.add("look.subsurface", fraction, UMAX_FIELD(look.subsurface),
           "share of the rest in which light wanders, as in wax or skin; closed surfaces only");
  keys.add("look.subsurface_radius", RadiiKind(), UMAX_FIELD(look.subsurface_radius),
           "how far red, green and blue light go between two turns, on the average");
}

}  // namespace umax
