#include "tools/setup/body_maps.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "core/base/error.h"
#include "embedding/maps/vdb_grid.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/distance_grid.h"
#include "tools/setup/named_error.h"

namespace umax {
namespace {

/// Signed distances of the body's surface; null for a body of its own hexes, which are all solid.
std::shared_ptr<const SampledDistance> solid_of(const BodySetup& setup, const Body& body) {
  if (setup.shape.hexes && setup.shape.hexes->are_the_body()) return nullptr;
  if (body.rest_distance) return body.rest_distance;
  return std::make_shared<const SampledDistance>(make_distance_grid(setup.shape.mesh));
}

HexFactors factors_of_grid(const MapSource& map, const BodySetup& setup, const Body& body) {
  const VdbGrid grid(map.path, map.grid, VdbGrid::Kind::number);
  return factors_from_grid(grid, setup.shape.world_from_file.inverse(), setup.lattice, solid_of(setup, body).get(),
                           map.range);
}

HexFactors factors_of_paint(const MapSource& map, const BodySetup& setup) {
  const FactorRange range = map.range.value_or(FactorRange());
  const TriangleMesh& own = setup.shape.mesh;
  if (map.own_paint) return factors_from_paint(own, own, setup.lattice, range);
  TriangleMesh painted = load_mesh(map.path).mesh;
  const Eigen::Affine3d& placed = setup.shape.world_from_file;
  painted.positions =
      ((painted.positions * placed.linear().transpose()).rowwise() + placed.translation().transpose()).eval();
  return factors_from_paint(painted, own, setup.lattice, range);
}

/// Calls work; an error without a place gets the map's file, and all get body and key.
template <class Work>
auto reading_map(const BodySetup& setup, const std::string& key, const MapSource& map, Work work) {
  return named("body." + setup.name + "." + key, [&] {
    try {
      return work();
    } catch (const Error& error) {
      ErrorText text = error.text();
      if (text.where.empty() && !map.own_paint) text.where = map.path.string();
      throw Error(error.fault(), text);
    }
  });
}

BodyMap read_map(const std::string& key, const MapSource& map, const BodySetup& setup, const Body& body) {
  return {.key = key,
          .source = map.own_paint ? "the paint of the mesh" : map.path.string(),
          .hexes = reading_map(setup, key, map, [&] {
            return map.is_grid() ? factors_of_grid(map, setup, body) : factors_of_paint(map, setup);
          })};
}

void apply_fibre_map(const BodyDescription& description, const BodySetup& setup, Body& body,
                     std::vector<std::string>& warnings) {
  const MapSource& map = description.fibre_map;
  const std::string key = "limit.fibre.direction_map";
  const HexDirections found = reading_map(setup, key, map, [&] {
    const VdbGrid grid(map.path, map.grid, VdbGrid::Kind::direction);
    return directions_from_grid(grid, setup.shape.world_from_file.inverse(), setup.lattice, solid_of(setup, body).get(),
                                description.part_limits.fibre_direction);
  });
  body.fibre_directions = found.directions;
  if (found.num_outside > 0)
    warnings.push_back(
        fmt::format("body.{}.{}: {} of {} hexes have no direction in the map and take limit.fibre.direction",
                    setup.name, key, found.num_outside, found.directions.rows()));
  if (description.part_limits.fibre.kind == LimitKind::none)
    warnings.push_back(fmt::format(
        "body.{}.{}: the body has no limit on its fibre; give one, such as limit.fibre.stretch", setup.name, key));
}

void multiply(const VectorXd& by, VectorXd& factors) {
  if (factors.size() == 0)
    factors = by;
  else
    factors.array() *= by.array();
}

std::string ends_text(const HexFactors& hexes) {
  return fmt::format("{:.4g} … {:.4g}", hexes.factors.minCoeff(), hexes.factors.maxCoeff());
}

void warn_of(const std::string& body, const BodyMap& map, std::vector<std::string>& warnings) {
  const HexFactors& hexes = map.hexes;
  const std::string where = fmt::format("body.{}.{}", body, map.key);
  if (hexes.num_outside > 0)
    warnings.push_back(fmt::format("{}: {} of {} hexes lie outside the map and keep the body's own value", where,
                                   hexes.num_outside, hexes.factors.size()));
  if (hexes.num_clamped > 0)
    warnings.push_back(
        fmt::format("{}: the map's values of {} hexes ({:.4g} … {:.4g}) lie beyond its ends and were "
                    "clamped to factors of {}",
                    where, hexes.num_clamped, hexes.least, hexes.largest, ends_text(hexes)));
}

}  // namespace

void apply_maps(const BodyDescription& description, BodySetup& setup, Body& body, std::vector<std::string>& warnings) {
  if (description.young_map.is_set()) {
    setup.young_map = read_map("material.young_map", description.young_map, setup, body);
    multiply(setup.young_map->hexes.factors, body.young_factor);
    warn_of(setup.name, *setup.young_map, warnings);
  }
  if (description.fibre_map.is_set()) apply_fibre_map(description, setup, body, warnings);
  if (!description.limit_map.is_set()) return;
  setup.limit_map = read_map("limit.map", description.limit_map, setup, body);
  multiply(setup.limit_map->hexes.factors, body.limit_factor);
  warn_of(setup.name, *setup.limit_map, warnings);
  const PartLimitOptions& parts = description.part_limits;
  if (description.limit.kind == LimitKind::none && parts.volumetric.kind == LimitKind::none &&
      parts.deviatoric.kind == LimitKind::none && parts.fibre.kind == LimitKind::none)
    warnings.push_back(fmt::format(
        "body.{}.limit.map: the body has no limit that it could act on; give one, such as limit.stretch", setup.name));
}

std::string describe(const BodyMap& map) {
  const HexFactors& hexes = map.hexes;
  std::string text = fmt::format("factors of {}, from {}", ends_text(hexes), map.source);
  if (hexes.num_outside > 0) text += fmt::format("; {} of {} hexes outside", hexes.num_outside, hexes.factors.size());
  if (hexes.num_clamped > 0) text += fmt::format("; {} clamped", hexes.num_clamped);
  return text;
}

}  // namespace umax
