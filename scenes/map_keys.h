// Scene keys of maps: factors on one of a body's values, from a file or from the paint of its mesh.
#pragma once

#include "scenes/mesh_keys.h"

namespace umax {

/// [black, white], two factors.
struct FactorRangeKind {
  using Value = FactorRange;
  NumberKind factor{units::ratio, {.low = least_factor, .high = largest_factor}};
  Value read(const SceneValue& value) const {
    const auto* pair = value.as<SceneValue::Array>();
    if (!pair || pair->size() != 2)
      throw value_error(value, "must be two factors, at black and at white", "write [0.1, 1]");
    return {factor.read((*pair)[0]), factor.read((*pair)[1])};
  }
  std::string write(const Value& range) const {
    return "[" + factor.write(range.black) + ", " + factor.write(range.white) + "]";
  }
  std::string type() const { return "[black, white], " + factor.range.table_text(); }
};

/// The keys `name`_grid and `name`_sha256 of a map's file; map_of(body): its MapSource.
template <class Builder, class MapOf>
void add_map_file_keys(Builder& keys, const std::string& name, MapOf map_of, const std::string& only_grid) {
  using Text = std::optional<std::string>;
  keys.add_custom(
      name + "_grid", "text", "name of the grid in the .vdb", {.unset = only_grid},
      [map_of](const SceneValue& wanted, BodyDescription& body) {
        if (!map_of(body).is_grid())
          throw value_error(wanted, "does not fit here", "it belongs to a map from a .vdb file");
        map_of(body).grid = TextKind().read(wanted);
      },
      [map_of](const BodyDescription& body) -> Text {
        const std::string& grid = map_of(body).grid;
        return grid.empty() ? std::nullopt : Text(toml_string(grid));
      });
  keys.add_custom(
      name + "_sha256", "text", "SHA-256 of the map's file; another file is refused", {.unset = "not checked"},
      [map_of](const SceneValue& wanted, BodyDescription& body) {
        const MapSource& map = map_of(body);
        if (map.path.empty()) throw value_error(wanted, "does not fit here", "it belongs to a map from a file");
        check_sha256(wanted, "map", map.path, map.sha256);
      },
      [map_of](const BodyDescription& body) -> Text {
        const MapSource& map = map_of(body);
        return map.path.empty() ? std::nullopt : Text(toml_string(map.sha256));
      });
}

/// The key `name`: a file, "none" or, of paint, "mesh".
template <class Builder, class MapOf>
void add_map_key(Builder& keys, const std::string& name, MapOf map_of, bool has_paint, const std::string& meaning) {
  const auto set = [map_of, has_paint](const SceneValue& wanted, BodyDescription& body) {
    const std::string word = TextKind().read(wanted);
    MapSource& map = map_of(body);
    map = MapSource();
    map.own_paint = has_paint && word == "mesh";
    if (map.own_paint || word == "none") return;
    const std::filesystem::path path = ExistingFileKind().read(wanted);
    if (!has_paint && !is_vdb_file(path))
      throw value_error(wanted, "is no .vdb file by its name", "give an OpenVDB file");
    map.path = path;
    map.sha256 = sha256_of_file(path);
  };
  const auto get = [map_of](const BodyDescription& body) -> std::optional<std::string> {
    const MapSource& map = map_of(body);
    if (!map.is_set()) return std::nullopt;
    return map.own_paint ? toml_string("mesh") : PathKind().write(map.path);
  };
  keys.add_custom(name, has_paint ? R"(path, "mesh" or "none")" : R"(path or "none")", meaning,
                  {.unset = "\"none\"", .resets = {name + "_grid", name + "_sha256"}}, set, get);
}

/// The keys `name`, `name`_range and those of its file. value: on what the factors act.
template <class Builder, class MapOf>
void add_factor_map_keys(Builder& keys, const std::string& name, MapOf map_of, const std::string& value) {
  add_map_key(keys, name, map_of, true,
              "factors on " + value +
                  " of each hex: a float grid (.vdb) or painted vertices (PLY, OBJ, glTF) in the coordinates of the "
                  "body's mesh file; \"mesh\": the paint of the body's own mesh");
  const FactorRangeKind range;
  keys.add_custom(
      name + "_range", range.type(), "the factors of 0 (black) and 1 (white), linear between",
      {.unset = range.write(FactorRange()) + "; .vdb: the numbers are the factors"},
      [map_of, range](const SceneValue& wanted, BodyDescription& body) {
        if (!map_of(body).is_set()) throw value_error(wanted, "does not fit here", "it belongs to a map");
        map_of(body).range = range.read(wanted);
      },
      [map_of, range](const BodyDescription& body) -> std::optional<std::string> {
        const MapSource& map = map_of(body);
        if (!map.is_set() || (map.is_grid() && !map.range)) return std::nullopt;
        return range.write(map.range.value_or(FactorRange()));
      });
  add_map_file_keys(keys, name, map_of, "its only float grid");
}

/// The keys of a map of directions.
template <class Builder, class MapOf>
void add_direction_map_keys(Builder& keys, const std::string& name, MapOf map_of) {
  add_map_key(keys, name, map_of, false,
              "directions of the fibre: a vec3s grid (.vdb) in the coordinates of the body's mesh file; hexes that it "
              "does not reach keep limit.fibre.direction");
  add_map_file_keys(keys, name, map_of, "its only vec3s grid");
}

}  // namespace umax
