#include "core/model/model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

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
  for (Eigen::Index e = 0; e < body.lattice.num_hexes(); ++e) {
    const HexShape& shape = model.shapes[model.hex_shape[first_hex + e]];
    // the nodes of a box have equal shares
    const Vector8d volumes =
        body.lattice.is_regular() ? Vector8d::Constant(shape.volume / 8).eval() : node_volumes(shape);
    for (int n = 0; n < 8; ++n)
      model.node_mass[first_node + body.lattice.hexes(e, n)] += body.material.density * volumes[n] * fractions[e];
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

void append(const Body& body, Model& model) {
  validate(body);
  const Eigen::Index node = model.num_nodes(), hex = model.num_hexes(), point = model.surface.size();
  const Eigen::Index num_nodes = body.lattice.num_nodes(), num_hexes = body.lattice.num_hexes();

  Model::BodyRange range;
  range.name = body.name;
  range.first_node = int(node), range.num_nodes = int(num_nodes);
  range.first_hex = int(hex), range.num_hexes = int(num_hexes);
  range.first_point = int(point), range.num_points = int(body.surface.size());
  range.material = body.material;
  range.limit = body.limit;
  range.part_limits = body.part_limits;
  range.friction = body.friction;
  range.cell_size = smallest_edge(body.lattice);
  range.cells = body.lattice.cells;
  range.cell_edges = body.lattice.cell_size;
  range.rest_distance = body.rest_distance;
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

  model.surface.hex.conservativeResize(point + body.surface.size());
  model.surface.hex.tail(body.surface.size()) = body.surface.hex.array() + int(hex);
  model.surface.weights.conservativeResize(point + body.surface.size(), 8);
  model.surface.weights.bottomRows(body.surface.size()) = body.surface.weights;

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

}  // namespace

Model make_model(const std::vector<Body>& bodies, const std::vector<Obstacle>& obstacles) {
  Model model;
  model.rest_positions.resize(0, 3);
  model.initial_velocities.resize(0, 3);
  model.hexes.resize(0, 8);
  model.surface.weights.resize(0, 8);
  model.fibre_directions.resize(0, 3);
  model.limit_starts.setZero(1);
  for (const Body& body : bodies) append(body, model);
  group_corners(model);
  for (const Obstacle& obstacle : obstacles) validate(obstacle);
  model.obstacles = obstacles;
  return model;
}

double young_at(const Model& model, Eigen::Index hex, double time) {
  return model.bodies[model.hex_body[hex]].material.young.at(time) * model.young_factor[hex];
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
