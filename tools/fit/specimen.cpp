#include "tools/fit/specimen.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/element/material.h"
#include "core/step/step.h"

namespace umax {
namespace {

// Young's modulus is 1 Pa and lengths are about 1 m: the law is linear in the modulus and knows no length.
constexpr double young = 1;
constexpr double length = 1;              // [m] of a tension specimen along y; height of a sheared layer
constexpr double total_mass = 1;          // [kg] of the weights
constexpr double weightless = 1e-9;       // [kg] of a node without weight
constexpr double rest_step = 1e4;         // [s] so long that inertia is 1e-8 of the stiffness: a state of rest
constexpr double toppling_load = 0.3;     // [-] where a guide is needed
constexpr double guided_step = 0.5;       // [s] inertia is as stiff as the block
constexpr double rest_tolerance = 1e-10;  // [m] of a guided weight
constexpr int max_guided_rounds = 200;
constexpr double tolerance = 1e-8;        // [-] of the solver
constexpr double width_tolerance = 1e-9;  // [-] of the grip that follows the specimen's width
constexpr double flattened = -0.99;       // [-] stretch from which on a specimen counts as turned inside out
constexpr int max_width_rounds = 30;
constexpr double largest_increment = 0.05;  // [-] of load in one step, or half of the load

bool is_at(double a, double b) {
  return std::abs(a - b) < 1e-9;
}

/// One layer of hexes, twice as wide as high: weights that push do not make it buckle.
Lattice uniaxial_lattice() {
  return make_box_lattice({2, 1, 2}, Vector3d(-1, 0, -1), Vector3d(1, length, 1));
}

/// Two layers, six times as long as high, as a lap joint: what happens at their free ends matters little.
Lattice shear_lattice() {
  return make_box_lattice({6, 2, 1}, Vector3d(-3, -length, -0.5), Vector3d(1, length, 1));
}

}  // namespace

struct Specimen::Rig {
  Loading loading;
  bool limited;
  Lattice lattice;
  std::vector<int> held, loaded;  // nodes
  Model model;
  Workspace workspace;
  State state;
  double area = 0;   // [m^2] that bears the load
  double width = 1;  // [-] of the grip over the width at rest
  double load = 0;   // [-] that the state is at rest under

  explicit Rig(const SpecimenOptions& options)
      : loading(options.loading),
        limited(std::isfinite(options.limit_stretch)),
        lattice(options.loading == Loading::shear ? shear_lattice() : uniaxial_lattice()),
        model(make_model({body(options)}, {})),
        workspace(model),
        state(rest_state(model)) {
    area = loading == Loading::shear ? 2 * 6.0 : 4.0;  // both faces of the middle plate
    set_weights();
  }

  Body body(const SpecimenOptions& options) {
    Body body;
    body.name = "specimen";
    body.lattice = lattice;
    body.material = {.young = young, .poisson = options.poisson, .mass = MassModel::lattice};
    if (std::isfinite(options.limit_stretch))
      body.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = options.limit_stretch};
    body.surface.weights.resize(0, 8);
    for (int node = 0; node < int(lattice.num_nodes()); ++node) {
      const double y = lattice.rest_positions(node, 1);
      const bool shear = loading == Loading::shear;
      if (is_at(y, shear ? -length : 0) || (shear && is_at(y, length))) held.push_back(node);
      if (is_at(y, shear ? 0 : length)) loaded.push_back(node);
    }
    body.fixed_nodes = held;
    return body;
  }

  /// A node weighs in proportion to the area of the loaded face around it.
  void set_weights() {
    const Points& rest = lattice.rest_positions;
    const Eigen::RowVector3d low = rest.colwise().minCoeff(), high = rest.colwise().maxCoeff();
    model.node_mass.setConstant(weightless);
    double sum = 0;
    for (const int node : loaded) {
      double share = 1;
      for (const int axis : {0, 2})
        if (is_at(rest(node, axis), low[axis]) || is_at(rest(node, axis), high[axis])) share /= 2;
      model.node_mass[node] = share;
      sum += share;
    }
    for (const int node : loaded) model.node_mass[node] *= total_mass / sum;
  }

  /// Brings the specimen to rest under the load with the grip as wide as it is.
  bool settle(double at_load) {
    if (loading != Loading::compression || at_load < toppling_load) return advance(at_load, rest_step);
    const State start = state;
    if (limited && advance(at_load, rest_step)) return true;
    // A weight on so soft a block topples it. Its inertia and the symmetry of the block guide it instead, in many short
    // steps that come to rest.
    state = start;
    for (int round = 0; round < max_guided_rounds; ++round) {
      const Points before = state.positions;
      if (!advance(at_load, guided_step)) return false;
      make_symmetric();
      if ((state.positions - before).cwiseAbs().maxCoeff() < rest_tolerance) return true;
    }
    return false;
  }

  /// One step from a standstill.
  bool advance(double at_load, double time_step) {
    const double force = at_load * young * area;
    const Vector3d direction = loading == Loading::shear         ? Vector3d::UnitX()
                               : loading == Loading::compression ? Vector3d(-Vector3d::UnitY())
                                                                 : Vector3d::UnitY();
    StepOptions options{.time_step = time_step, .gravity = force / total_mass * direction};
    options.solver.tolerance = tolerance;
    options.solver.max_newton_iterations = 60;
    options.solver.max_halvings = 0;  // the start is at rest: a shorter step is another problem, not an easier one
    state.velocities.setZero();
    return step(model, options, workspace, state).status == StepStatus::converged && state.positions.allFinite();
  }

  /// Takes the mean of the block and its mirror images in x and z.
  void make_symmetric() {
    const Points rest = lattice.rest_positions;
    for (const int axis : {0, 2}) {
      const Points positions = state.positions;
      for (int node = 0; node < int(rest.rows()); ++node) {
        Eigen::RowVector3d mirror = rest.row(node);
        mirror[axis] = -mirror[axis];
        Eigen::Index image = 0;
        (rest.rowwise() - mirror).rowwise().squaredNorm().minCoeff(&image);
        Eigen::RowVector3d reflected = positions.row(image);
        reflected[axis] = -reflected[axis];
        state.positions.row(node) = (positions.row(node) + reflected) / 2;
      }
    }
  }

  /// Mean width of the loaded face over that at rest.
  double loaded_width() const {
    double now = 0, rest = 0;
    for (const int node : loaded)
      for (const int axis : {0, 2}) {
        const double sign = lattice.rest_positions(node, axis) < 0 ? -1 : 1;
        now += sign * state.positions(node, axis);
        rest += sign * lattice.rest_positions(node, axis);
      }
    return now / rest;
  }

  void set_grip(double to_width) {
    width = to_width;
    for (const int node : held)
      for (const int axis : {0, 2}) state.positions(node, axis) = width * lattice.rest_positions(node, axis);
  }

  /// The grip takes the width of the far face; secant steps, since that width is nearly linear in the grip's.
  bool settle_with_width(double at_load) {
    double last_width = 0, last_error = 0;
    for (int round = 0; round < max_width_rounds; ++round) {
      if (!settle(at_load)) return false;
      const double error = loaded_width() - width;
      if (std::abs(error) < width_tolerance) return true;
      double next = width + error;
      if (round > 0 && error != last_error) next = width - error * (width - last_width) / (error - last_error);
      if (!(next > 0 && std::abs(next - width) < 0.5)) next = width + error;
      last_width = width;
      last_error = error;
      set_grip(next);
    }
    return false;
  }

  SpecimenReading read() const {
    SpecimenReading reading;
    const int axis = loading == Loading::shear ? 0 : 1;
    for (const int node : loaded)
      reading.stretch += model.node_mass[node] / total_mass / length *
                         (state.positions(node, axis) - lattice.rest_positions(node, axis));
    if (loading != Loading::shear) reading.lateral_stretch = loaded_width() - 1;
    double density = 0;
    for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const CorotatedHex hex = corotate(shape, RotationEstimate::centre, hex_nodes(model, state.positions, e));
      density = std::max(density, elastic_energy(shape.stiffness, young, hex) / shape.volume);
    }
    reading.peak_stretch = stretch_from_density(young, density);
    return reading;
  }
};

Specimen::Specimen(const SpecimenOptions& options) : rig_(std::make_unique<Rig>(options)) {}
Specimen::~Specimen() = default;
Specimen::Specimen(Specimen&&) noexcept = default;

std::optional<SpecimenReading> Specimen::at(double load) {
  if (load == 0) {  // where forces are relative to none
    rig_->state = rest_state(rig_->model);
    rig_->width = 1;
    rig_->load = 0;
    return SpecimenReading{};
  }
  const State start = rig_->state;
  const double start_load = rig_->load, start_width = rig_->width;
  const int parts = std::max(1, int(std::ceil(std::abs(load - start_load) / std::max(largest_increment, load / 2))));
  bool bears = true;
  for (int part = 1; bears && part <= parts; ++part) {
    const double part_load = start_load + (load - start_load) * part / parts;
    bears = rig_->loading == Loading::shear ? rig_->settle(part_load) : rig_->settle_with_width(part_load);
    const SpecimenReading reading = rig_->read();
    bears = bears && std::min(reading.stretch, reading.lateral_stretch) > flattened;
  }
  if (!bears) {
    rig_->state = start;
    rig_->width = start_width;
    return std::nullopt;
  }
  rig_->load = load;
  return rig_->read();
}

}  // namespace umax
