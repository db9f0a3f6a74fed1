#include "core/model/model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/model/filling.h"
#include "core/model/hex_limits.h"

namespace umax {
namespace {

// make_hex_shape() that names the hex
HexShape shape_of(const Body& body, Eigen::Index hex, const Matrix8x3d& nodes) {
  try {
    return make_hex_shape(nodes, body.material.poisson);
  } catch (const Error& error) {
    ErrorText text = error.text();
    text.where = "body." + body.name + ".cage: hex " + std::to_string(hex);
    throw Error(error.fault(), text);
  }
}

// equal cells of a regular lattice share one shape; an irregular hex has its own
void append_shapes(const Body& body, Eigen::Index first_hex, Model& model) {
  const bool regular = body.lattice.is_regular();
  model.shapes.reserve(model.shapes.size() + std::size_t(regular ? 1 : body.lattice.num_hexes()));
  for (Eigen::Index e = 0; e < body.lattice.num_hexes(); ++e) {
    if (!regular || e == 0) {
      Matrix8x3d nodes = rest_nodes(body.lattice, e);
      if (regular)  // exact corners: the shape must not carry the rounding of one cell's place in the grid
        for (int n = 0; n < 8; ++n)
          for (int axis = 0; axis < 3; ++axis) nodes(n, axis) = (n >> (2 - axis) & 1) * body.lattice.cell_size[axis];
      model.shapes.push_back(shape_of(body, e, nodes));
    }
    model.hex_shape[first_hex + e] = int(model.shapes.size()) - 1;
  }
}

void append_masses(const Body& body, Eigen::Index first_node, Eigen::Index first_hex, Model& model) {
  const VectorXd fractions = body.material.mass == MassModel::mesh ? weighing_fractions(body.lattice)
                                                                   : VectorXd::Ones(body.lattice.num_hexes()).eval();
  const double density = body.material.density.at(0);
  for (Eigen::Index e = 0; e < body.lattice.num_hexes(); ++e) {
    const HexShape& shape = model.shapes[model.hex_shape[first_hex + e]];
    // the nodes of a box have equal shares
    const Vector8d volumes =
        body.lattice.is_regular() ? Vector8d::Constant(shape.volume / 8).eval() : node_volumes(shape);
    for (int n = 0; n < 8; ++n)
      model.node_mass[first_node + body.lattice.hexes(e, n)] += density * volumes[n] * fractions[e];
  }
}

void set_initial_velocities(const Body& body, Eigen::Index first_node, Model& model) {
  const Eigen::Index count = body.lattice.num_nodes();
  const auto mass = model.node_mass.segment(first_node, count);
  const Vector3d centre = (body.lattice.rest_positions.transpose() * mass) / mass.sum();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3d arm = body.lattice.rest_positions.row(i).transpose() - centre;
    const Vector3d velocity = body.velocity + body.spin.cross(arm);
    if (!model.node_fixed[first_node + i]) model.initial_velocities.row(first_node + i) = velocity.transpose();
  }
}

double smallest_edge(const Lattice& lattice) {
  if (lattice.is_regular()) return lattice.cell_size.minCoeff();
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    for (int n = 0; n < 8; ++n)
      for (int bit = 1; bit < 8; bit <<= 1)
        if (!(n & bit))
          smallest = std::min(smallest, (lattice.rest_positions.row(lattice.hexes(e, n)) -
                                         lattice.rest_positions.row(lattice.hexes(e, n | bit)))
                                            .norm());
  return smallest;
}

// Points that an earlier body has in the same places of the same hexes are that body's: of a crowd's vertices the weights alone
// would fill a gigabyte.
std::shared_ptr<const EmbeddedPoints> shared_points(EmbeddedPoints points, const Model& model) {
  for (const Model::BodyRange& body : model.bodies)
    if (body.surface->size() == points.size() && body.surface->hex == points.hex &&
        body.surface->weights == points.weights)
      return body.surface;
  return std::make_shared<const EmbeddedPoints>(std::move(points));
}

const Model::BodyRange& body_of_point(const Model& model, Eigen::Index point) {
  const auto next =
      std::upper_bound(model.bodies.begin(), model.bodies.end(), point,
                       [](Eigen::Index of, const Model::BodyRange& body) { return of < body.first_point; });
  return *std::prev(next);
}

void append(Body body, Model& model) {
  validate(body);
  const Eigen::Index node = model.num_nodes(), hex = model.num_hexes(), point = model.num_points();
  const Eigen::Index num_nodes = body.lattice.num_nodes(), num_hexes = body.lattice.num_hexes();

  Model::BodyRange range;
  range.name = body.name;
  range.first_node = int(node), range.num_nodes = int(num_nodes);
  range.first_hex = int(hex), range.num_hexes = int(num_hexes);
  range.first_point = int(point), range.num_points = int(body.surface.size());
  range.material = body.material;
  range.limit = body.limit;
  range.part_limits = body.part_limits;
  range.friction = body.friction.at(0);
  range.friction_keys = body.friction;
  range.contact = body.contact;
  range.cell_size = smallest_edge(body.lattice);
  range.cells = body.lattice.cells;
  range.cell_edges = body.lattice.cell_size;
  range.rest_distance = body.rest_distance;
  range.rest_surface = body.rest_surface;
  range.rest_scale = body.rest_scale;
  range.rest_pose = body.rest_pose;
  range.pins = body.pins;
  range.surface = shared_points(std::move(body.surface), model);
  model.bodies.push_back(range);

  model.rest_positions.conservativeResize(node + num_nodes, 3);
  model.rest_positions.bottomRows(num_nodes) = body.lattice.rest_positions;
  model.initial_velocities.conservativeResizeLike(Points::Zero(node + num_nodes, 3));
  model.node_mass.conservativeResizeLike(VectorXd::Zero(node + num_nodes));
  model.node_fixed.resize(node + num_nodes, 0);
  for (const int fixed : body.fixed_nodes) model.node_fixed[node + fixed] = 1;

  model.hexes.conservativeResize(hex + num_hexes, 8);
  model.hexes.bottomRows(num_hexes) = body.lattice.hexes.array() + int(node);
  model.hex_shape.conservativeResize(hex + num_hexes);
  model.hex_body.conservativeResize(hex + num_hexes);
  model.hex_body.tail(num_hexes).setConstant(int(model.bodies.size()) - 1);
  model.young_factor.conservativeResizeLike(VectorXd::Ones(hex + num_hexes));
  model.limit_factor.conservativeResizeLike(VectorXd::Ones(hex + num_hexes));
  if (body.young_factor.size() > 0) model.young_factor.tail(num_hexes) = body.young_factor;
  if (body.limit_factor.size() > 0) model.limit_factor.tail(num_hexes) = body.limit_factor;

  append_shapes(body, hex, model);
  append_limits(body, hex, model);
  append_masses(body, node, hex, model);
  set_initial_velocities(body, node, model);
}

void group_corners(Model& model) {
  model.corner_starts.setZero(model.num_nodes() + 1);
  for (const int node : model.hexes.reshaped()) ++model.corner_starts[node + 1];
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    model.corner_starts[node + 1] += model.corner_starts[node];
  model.corners.resize(8 * model.num_hexes());
  VectorXi next = model.corner_starts;
  for (int e = 0; e < int(model.num_hexes()); ++e)
    for (int n = 0; n < 8; ++n) model.corners[next[model.hexes(e, n)]++] = 8 * e + n;
}

const BodyPair* pair_of(const Model& model, int a, int b) {
  for (const BodyPair& pair : model.pairs)
    if ((pair.a == a && pair.b == b) || (pair.a == b && pair.b == a)) return &pair;
  return nullptr;
}

}  // namespace

Eigen::Map<const Vector8d> surface_weights(const Model& model, Eigen::Index point) {
  return surface_weights(body_of_point(model, point), point);
}

int surface_hex(const Model& model, Eigen::Index point) {
  const Model::BodyRange& body = body_of_point(model, point);
  return body.first_hex + body.surface->hex[point - body.first_point];
}

Model make_model(std::vector<Body> bodies, const std::vector<Obstacle>& obstacles, const std::vector<BodyPair>& pairs) {
  Model model;
  model.rest_positions.resize(0, 3);
  model.initial_velocities.resize(0, 3);
  model.hexes.resize(0, 8);
  model.fibre_directions.resize(0, 3);
  model.limit_starts.setZero(1);
  for (Body& body : bodies) append(std::exchange(body, {}), model);
  group_corners(model);
  model.node_mass_t0 = model.node_mass;
  for (const Obstacle& obstacle : obstacles) validate(obstacle);
  model.obstacles = obstacles;
  model.pairs = pairs;
  return model;
}

bool has_keyed_mass_or_friction(const Model& model) {
  return std::any_of(model.bodies.begin(), model.bodies.end(), [](const Model::BodyRange& body) {
    return !body.material.density.is_constant() || !body.friction_keys.is_constant();
  });
}

bool bring_to(Model& model, double time) {
  bool changes = false;
  for (Model::BodyRange& body : model.bodies) {
    const double friction = body.friction_keys.at(time);
    changes = changes || friction != body.friction;
    body.friction = friction;
    if (body.material.density.is_constant()) continue;
    const double share = body.material.density.at(time) / body.material.density.at(0);
    const VectorXd mass = model.node_mass_t0.segment(body.first_node, body.num_nodes) * share;
    auto now = model.node_mass.segment(body.first_node, body.num_nodes);
    changes = changes || now != mass;
    now = mass;
  }
  return changes;
}

Model part_of(const Model& model, const std::vector<int>& bodies) {
  Model part;
  int num_nodes = 0, num_hexes = 0, num_points = 0;
  for (const int b : bodies) {
    Model::BodyRange body = model.bodies[b];
    body.first_node = num_nodes, num_nodes += body.num_nodes;
    body.first_hex = num_hexes, num_hexes += body.num_hexes;
    body.first_point = num_points, num_points += body.num_points;
    part.bodies.push_back(body);
  }
  part.obstacles = model.obstacles;
  part.limit_forms = model.limit_forms;
  for (BodyPair pair : model.pairs) {
    const auto a = std::find(bodies.begin(), bodies.end(), pair.a), b = std::find(bodies.begin(), bodies.end(), pair.b);
    if (a == bodies.end() || b == bodies.end()) continue;
    pair.a = int(a - bodies.begin()), pair.b = int(b - bodies.begin());
    part.pairs.push_back(pair);
  }
  part.rest_positions.resize(num_nodes, 3);
  part.initial_velocities.resize(num_nodes, 3);
  part.node_mass.resize(num_nodes);
  part.hexes.resize(num_hexes, 8);
  part.hex_shape.resize(num_hexes);
  part.hex_body.resize(num_hexes);
  part.young_factor.resize(num_hexes);
  part.limit_factor.resize(num_hexes);
  part.fibre_directions.resize(num_hexes, 3);
  part.limit_starts.setZero(1);
  std::vector<int> shapes(model.shapes.size(), -1);  // there to here
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Model::BodyRange &from = model.bodies[bodies[i]], &to = part.bodies[i];
    const auto nodes = [&](auto& here, const auto& there) {
      here.middleRows(to.first_node, to.num_nodes) = there.middleRows(from.first_node, from.num_nodes);
    };
    const auto hexes = [&](auto& here, const auto& there) {
      here.middleRows(to.first_hex, to.num_hexes) = there.middleRows(from.first_hex, from.num_hexes);
    };
    nodes(part.rest_positions, model.rest_positions);
    nodes(part.initial_velocities, model.initial_velocities);
    nodes(part.node_mass, model.node_mass);
    const auto fixed = model.node_fixed.begin() + from.first_node;
    part.node_fixed.insert(part.node_fixed.end(), fixed, fixed + from.num_nodes);
    hexes(part.young_factor, model.young_factor);
    hexes(part.limit_factor, model.limit_factor);
    hexes(part.fibre_directions, model.fibre_directions);
    hexes(part.hexes, model.hexes);
    part.hexes.middleRows(to.first_hex, to.num_hexes).array() += to.first_node - from.first_node;
    part.hex_body.segment(to.first_hex, to.num_hexes).setConstant(int(i));
    part.limit_starts.conservativeResize(to.first_hex + to.num_hexes + 1);
    for (int e = 0; e < to.num_hexes; ++e) {
      int& shape = shapes[model.hex_shape[from.first_hex + e]];
      if (shape < 0) {
        shape = int(part.shapes.size());
        part.shapes.push_back(model.shapes[model.hex_shape[from.first_hex + e]]);
      }
      part.hex_shape[to.first_hex + e] = shape;
      for (int l = model.limit_starts[from.first_hex + e]; l < model.limit_starts[from.first_hex + e + 1]; ++l) {
        part.limits.push_back(model.limits[l]);
        part.limits.back().hex = to.first_hex + e;
      }
      part.limit_starts[to.first_hex + e + 1] = int(part.limits.size());
    }
  }
  group_corners(part);
  return part;
}

bool may_touch(const Model& model, int a, int b) {
  if (const BodyPair* pair = pair_of(model, a, b)) return pair->touch;
  const auto allows = [&](int body) {
    const ContactWith with = model.bodies[body].contact;
    return with == ContactWith::all || (with == ContactWith::others && a != b);
  };
  return allows(a) && allows(b);
}

bool touches_obstacles(const Model& model, int body) {
  return model.bodies[body].contact != ContactWith::none;
}

double friction_between(const Model& model, int a, int b) {
  const BodyPair* pair = pair_of(model, a, b);
  return pair && pair->friction ? *pair->friction : std::max(model.bodies[a].friction, model.bodies[b].friction);
}

double young_at(const Model& model, Eigen::Index hex, double time) {
  return body_of(model, hex).material.young.at(time) * model.young_factor[hex];
}

State rest_state(const Model& model) {
  State state;
  state.positions = model.rest_positions;
  state.velocities = model.initial_velocities;
  state.limit_multipliers = VectorXd::Zero(Eigen::Index(model.limits.size()));
  return state;
}

Matrix8x3d hex_nodes(const Model& model, const Points& positions, Eigen::Index hex) {
  Matrix8x3d nodes;
  for (int n = 0; n < 8; ++n) nodes.row(n) = positions.row(model.hexes(hex, n));
  return nodes;
}

}  // namespace umax
