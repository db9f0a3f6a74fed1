#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/model/model.h"
#include "core/model/rest_surface.h"

namespace umax {
namespace {

[[noreturn]] void fail(const std::string& where, const std::string& what, double value, const std::string& remedy) {
  throw Error(Fault::bad_data, {where, what, std::to_string(value), remedy});
}

void require_positive(double value, const std::string& where, const std::string& remedy) {
  if (!(value > 0 && std::isfinite(value))) fail(where, "must be positive and finite", value, remedy);
}
void require_not_negative(double value, const std::string& where, const std::string& remedy) {
  if (!(value >= 0 && std::isfinite(value))) fail(where, "must be finite and not negative", value, remedy);
}
void require_finite(const Vector3d& value, const std::string& where) {
  for (const double component : value)
    if (!std::isfinite(component)) fail(where, "must be finite", component, "give three numbers");
}

void validate_material(const MaterialOptions& m, const std::string& where) {
  for (const double young : m.young.values) require_positive(young, where + ".young", "give e.g. \"500 kPa\"");
  if (!(m.poisson > -1 && m.poisson < 0.5))
    fail(where + ".poisson", "must lie in (-1, 0.5)", m.poisson, "0.3 suits most");
  for (const double density : m.density.values)
    require_positive(density, where + ".density", "give e.g. \"500 kg/m^3\"");
  for (const double damping : m.damping_mass.values)
    require_not_negative(damping, where + ".damping_mass", "0 switches it off");
  for (const double damping : m.damping_stiffness.values)
    require_not_negative(damping, where + ".damping_stiffness", "0 switches it off");
}

void validate_surface(const Body& body, const std::string& where) {
  const EmbeddedPoints& surface = body.surface;
  if (surface.weights.rows() != surface.size())
    fail(where, "needs 8 weights per point", double(surface.weights.rows()), "embed the mesh in this lattice");
  for (const int hex : surface.hex)
    if (hex < 0 || hex >= body.lattice.num_hexes())
      fail(where, "names a hex that the cage does not have", hex, "embed the mesh in this lattice");
  if (!surface.weights.allFinite())
    fail(where, "has weights that are not finite", std::numeric_limits<double>::quiet_NaN(), "check the mesh");
}

void validate_factors(const VectorXd& factors, Eigen::Index num_hexes, const std::string& where) {
  if (factors.size() == 0) return;
  if (factors.size() != num_hexes)
    fail(where, "needs one factor per hex, or none", double(factors.size()),
         "the cage has " + std::to_string(num_hexes) + " hexes");
  for (Eigen::Index e = 0; e < num_hexes; ++e)
    require_positive(factors[e], where + " of hex " + std::to_string(e), "1 leaves the body's value as it is");
}

void validate_limit(const EnergyLimitOptions& limit, const std::string& where) {
  if (limit.kind == LimitKind::none) return;
  for (const double value : limit.value.values) require_positive(value, where, "or set limit.kind = \"none\"");
}

void require_direction(const Vector3d& direction, const std::string& where) {
  require_finite(direction, where);
  require_positive(direction.norm(), where, "give a direction such as [1, 0, 0]");
}

void validate_limits(const Body& body, const std::string& where) {
  const PartLimitOptions& parts = body.part_limits;
  validate_limit(body.limit, where + ".limit");
  validate_limit(parts.volumetric, where + ".limit.volumetric");
  validate_limit(parts.deviatoric, where + ".limit.deviatoric");
  validate_limit(parts.fibre, where + ".limit.fibre");
  require_direction(parts.fibre_direction, where + ".limit.fibre.direction");
  const Eigen::Index rows = body.fibre_directions.rows();
  if (rows != 0 && rows != body.lattice.num_hexes())
    fail(where + ".fibre_directions", "needs one direction per hex, or none", double(rows),
         "the cage has " + std::to_string(body.lattice.num_hexes()) + " hexes");
  for (Eigen::Index e = 0; e < rows; ++e)
    require_direction(body.fibre_directions.row(e).transpose(),
                      where + ".fibre_directions of hex " + std::to_string(e));
}

void validate_cage(const Body& body, const std::string& where) {
  try {
    validate(body.lattice);
  } catch (const Error& error) {
    ErrorText text = error.text();
    text.where = where;
    throw Error(error.fault(), text);
  }
}

void validate_shape(const ObstacleShape& shape, const std::string& where) {
  if (const Ball* ball = std::get_if<Ball>(&shape))
    require_positive(ball->radius, where + ".radius", "give e.g. \"1 m\"");
  if (const Block* block = std::get_if<Block>(&shape))
    for (const double half : block->half_size) require_positive(half, where + ".size", "give e.g. \"1 m\"");
  if (const MeshShape* mesh = std::get_if<MeshShape>(&shape))
    if (!mesh->distance || mesh->distance->size.minCoeff() < 2 || !(mesh->distance->spacing > 0))
      fail(where + ".mesh", "needs a sampled distance", 0, "fill it from the mesh");
  if (const TriangleShape* triangles = std::get_if<TriangleShape>(&shape)) {
    if (!triangles->surface || triangles->surface->triangles.rows() == 0)
      fail(where + ".mesh", "needs triangles with area", 0, "give another mesh");
    require_not_negative(triangles->thickness, where + ".thickness", "give e.g. \"2 cm\"");
    if (!triangles->is_closed)
      require_positive(triangles->thickness, where + ".thickness", "an open mesh needs one: give e.g. \"2 cm\"");
  }
}

}  // namespace

void validate(const Body& body) {
  const std::string where = "body." + body.name;
  validate_cage(body, where + ".cage");
  validate_material(body.material, where + ".material");
  for (const double friction : body.friction.values)
    require_not_negative(friction, where + ".friction", "0 is frictionless");
  validate_limits(body, where);
  require_finite(body.velocity, where + ".velocity");
  require_finite(body.spin, where + ".spin");
  for (const int node : body.fixed_nodes)
    if (node < 0 || node >= body.lattice.num_nodes())
      fail(where + ".fixed_nodes", "names a node that the cage does not have", node, "");
  validate_factors(body.young_factor, body.lattice.num_hexes(), where + ".young_factor");
  validate_factors(body.limit_factor, body.lattice.num_hexes(), where + ".limit_factor");
  validate_surface(body, where + ".surface");
}

void validate(const Obstacle& obstacle) {
  const std::string where = "obstacle." + obstacle.name;
  require_not_negative(obstacle.friction, where + ".friction", "0 is frictionless");
  for (const Vector3d& position : obstacle.position.values) require_finite(position, where + ".position");
  for (const Vector3d& degrees : obstacle.rotation_degrees.values) require_finite(degrees, where + ".rotation");
  validate_shape(obstacle.shape, where);
}

}  // namespace umax
