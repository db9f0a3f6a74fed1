#include "tests/support/bodies.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/element/rotation.h"
#include "tests/support/catch.h"

namespace umax::test {

constexpr double tie = 1e-9;  // [cells] a point on the face of two hexes rides in the upper one, whatever rounding says

EmbeddedPoints embed_in_box(const Lattice& lattice, const Vector3i& num_cells, const Points& points) {
  EmbeddedPoints embedded;
  embedded.hex.resize(points.rows());
  embedded.weights.resize(points.rows(), 8);
  for (Eigen::Index p = 0; p < points.rows(); ++p) {
    const Vector3d scaled = (points.row(p).transpose() - lattice.origin).cwiseQuotient(lattice.cell_size);
    Vector3i cell;
    for (int axis = 0; axis < 3; ++axis)
      cell[axis] = std::clamp(int(std::floor(scaled[axis] + tie)), 0, num_cells[axis] - 1);
    embedded.hex[p] = (cell[0] * num_cells[1] + cell[1]) * num_cells[2] + cell[2];
    const Vector3d local = 2 * (scaled - cell.cast<double>()) - Vector3d::Ones();
    embedded.weights.row(p) = shape_functions(local).transpose();
  }
  return embedded;
}

Points as_points(const std::vector<Vector3d>& list) {
  Points points(Eigen::Index(list.size()), 3);
  for (std::size_t i = 0; i < list.size(); ++i) points.row(Eigen::Index(i)) = list[i].transpose();
  return points;
}

Points box_surface(const Vector3i& num_cells, const Vector3d& origin, const Vector3d& cell_size, int per_edge) {
  const Vector3i last = num_cells * per_edge;
  std::vector<Vector3d> points;
  for (int i = 0; i <= last[0]; ++i)
    for (int j = 0; j <= last[1]; ++j)
      for (int k = 0; k <= last[2]; ++k) {
        const Vector3i at(i, j, k);
        if ((at.array() == 0).any() || (at.array() == last.array()).any())
          points.push_back(origin + at.cast<double>().cwiseProduct(cell_size) / per_edge);
      }
  return as_points(points);
}

Points sphere_surface(const Vector3d& centre, double radius, int count) {
  Points points(count, 3);
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    points.row(i) = (centre + radius * Vector3d(r * std::cos(angle), z, r * std::sin(angle))).transpose();
  }
  return points;
}

std::shared_ptr<SampledDistance> sample_distance(const std::function<double(const Vector3d&)>& distance,
                                                 const Vector3d& low, const Vector3d& high, double spacing) {
  auto grid = std::make_shared<SampledDistance>();
  grid->origin = low - Vector3d::Constant(2 * spacing);
  grid->spacing = spacing;
  for (int axis = 0; axis < 3; ++axis) grid->size[axis] = int(std::ceil((high[axis] - low[axis]) / spacing)) + 5;
  for (int i = 0; i < grid->size[0]; ++i)
    for (int j = 0; j < grid->size[1]; ++j)
      for (int k = 0; k < grid->size[2]; ++k)
        grid->values.push_back(float(distance(grid->origin + spacing * Vector3d(i, j, k))));
  return grid;
}

double box_distance(const Vector3d& p, const Vector3d& low, const Vector3d& high) {
  return signed_distance(ObstacleShape(Block{0.5 * (high - low)}), p - 0.5 * (low + high)).distance;
}

Body make_block(const Vector3i& num_cells, const Vector3d& origin, double cell_size, int points_per_edge) {
  Body body;
  body.name = "block";
  const Vector3d cell = Vector3d::Constant(cell_size);
  body.lattice = make_box_lattice(num_cells, origin, cell);
  body.material.mass = MassModel::lattice;
  body.surface_rest = box_surface(num_cells, origin, cell, points_per_edge);
  body.surface = embed_in_box(body.lattice, num_cells, body.surface_rest);
  return body;
}

Body turned(Body body, const Matrix3d& rotation) {
  body.lattice.rest_positions = body.lattice.rest_positions * rotation.transpose();
  body.lattice.cells.resize(0, 3);
  body.surface_rest = body.surface_rest * rotation.transpose();
  return body;
}

Body make_beam() {
  Body body;
  body.name = "beam";
  body.lattice = make_box_lattice({14, 2, 2}, Vector3d::Zero(), {1.0 / 14, 0.06, 0.06});
  body.material = {.young = 150e3, .poisson = 0.3, .density = 500, .mass = MassModel::lattice};
  for (int node = 0; node < 9; ++node) body.fixed_nodes.push_back(node);
  body.surface.weights.resize(0, 8);
  return body;
}

int beam_tip() {
  return 14 * 9 + 4;
}

Body make_sphere(int cells, const Vector3d& centre, int num_points) {
  Body body;
  body.name = "sphere";
  const Vector3i num_cells = Vector3i::Constant(cells);
  body.lattice = make_box_lattice(num_cells, centre - Vector3d::Ones(), Vector3d::Constant(2.0 / cells));
  body.material = {.young = 150e3, .poisson = 0.3, .density = 500, .mass = MassModel::lattice};
  body.surface_rest = sphere_surface(centre, 1, num_points);
  body.surface = embed_in_box(body.lattice, num_cells, body.surface_rest);
  return body;
}

Obstacle make_ground(double friction) {
  return {.name = "ground", .shape = HalfSpace{}, .friction = friction};
}

void limit_energy(Body& body, double energy) {
  body.limit = {.kind = LimitKind::hard, .unit = LimitUnit::energy, .value = energy};
}

State simulate(const Model& model, const StepOptions& options, int steps) {
  State state = rest_state(model);
  simulate(model, options, steps, state, [](const StepReport&, const State&) {});
  return state;
}

double total_mass(const Model& model) {
  return model.node_mass.sum();
}

Vector3d mean_of(const VectorXd& mass, const Points& values) {
  return values.transpose() * mass / mass.sum();
}

Vector3d momentum(const Model& model, const State& state) {
  return state.velocities.transpose() * model.node_mass;
}

Vector3d angular_momentum(const Model& model, const State& state) {
  const Vector3d centre = mean_of(model.node_mass, state.positions);
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) {
    const Vector3d arm = state.positions.row(i).transpose() - centre, v = state.velocities.row(i).transpose();
    sum += model.node_mass[i] * arm.cross(v);
  }
  return sum;
}

std::string complaint(const Body& body) {
  try {
    make_model({body}, {});
  } catch (const Error& error) {
    CHECK(error.fault() == Fault::bad_data);
    return error.what();
  }
  return "";
}

}  // namespace umax::test
