#include "tests/support/hex_systems.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/element/elastic_energy.h"
#include "core/element/rotation.h"

namespace umax::test {
namespace {

Matrix3d rotation_of(const HexSystemOptions& options, double place, Random& random) {
  const Vector3d axis = random.vector(1) + Vector3d(0, 0, 1e-3);
  const double angle = options.turn * std::numbers::pi * random.uniform(-1, 1);
  const Matrix3d bent(Eigen::AngleAxisd(options.bend * place, Vector3d::UnitY()));
  return bent * Matrix3d(Eigen::AngleAxisd(angle, axis.normalized()));
}

Model as_model(const HexSystem& system, double poisson) {
  Body body;
  body.name = system.name;
  body.lattice = system.lattice;
  body.material.poisson = poisson;
  body.material.mass = MassModel::lattice;
  for (std::size_t n = 0; n < system.fixed.size(); ++n)
    if (system.fixed[n]) body.fixed_nodes.push_back(int(n));
  body.surface.weights.resize(0, 8);
  return make_model({body}, {});
}

void assemble(const HexSystemOptions& options, HexSystem& system) {
  const Model model = as_model(system, options.poisson);
  system.diagonal = options.inverse_time_squared * model.node_mass;
  system.assembled = make_system_matrix(model);
  reset(system.assembled);
  add_mass(system.diagonal, 1, system.assembled);
  for (Eigen::Index e = 0; e < system.lattice.num_hexes(); ++e) {
    CorotatedHex hex;
    hex.rotation = system.rotations[e];
    add_element(e, warped_hessian(system.shape.stiffness, system.stiffness[e], hex), system.assembled);
  }
}

}  // namespace

template <class S>
HexMatrix<S> HexSystem::matrix() const {
  HexMatrix<S> matrix = make_hex_matrix<S>(bricks);
  for (std::size_t e = 0; e < rotations.size(); ++e)
    set_frame_at(cell_slots[e], std::sqrt(stiffness[Eigen::Index(e)]) * rotations[e], matrix.frames);
  for (std::size_t n = 0; n < fixed.size(); ++n)
    matrix.diagonal[node_slots[n]] = S(fixed[n] ? -diagonal[Eigen::Index(n)] : diagonal[Eigen::Index(n)]);
  return matrix;
}
template HexMatrix<float> HexSystem::matrix<float>() const;
template HexMatrix<double> HexSystem::matrix<double>() const;

VectorXd HexSystem::random_vector(Random& random) const {
  VectorXd x(3 * lattice.num_nodes());
  for (double& value : x) value = random.uniform(-1, 1);
  for (std::size_t n = 0; n < fixed.size(); ++n)
    if (fixed[n]) x.segment<3>(3 * Eigen::Index(n)).setZero();
  return x;
}

HexSystem make_hex_system(const HexSystemOptions& options) {
  HexSystem system;
  Random random(17);
  system.name = options.name;
  system.lattice = make_lattice(options.cells, Vector3d::Zero(), options.cell_size);
  const Lattice& lattice = system.lattice;
  system.bricks = make_brick_lattice(lattice.cells, options.cell_size);
  system.shape = make_box_shape(options.cell_size, options.poisson);
  system.cell_slots = cell_slots(system.bricks, lattice.cells);
  system.node_slots = node_slots(system.bricks, lattice.cells, lattice.hexes, lattice.num_nodes());
  const Vector3d low = lattice.rest_positions.colwise().minCoeff(), high = lattice.rest_positions.colwise().maxCoeff();
  system.stiffness.resize(lattice.num_hexes());
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const double place = (lattice.rest_positions(lattice.hexes(e, 0), 0) - low[0]) / (high[0] - low[0]);
    system.rotations.push_back(rotation_of(options, place, random));
    const double choice = random.uniform(0, double(options.multipliers.size()));
    system.stiffness[e] = options.young * options.multipliers[std::size_t(choice)];
  }
  for (Eigen::Index n = 0; n < lattice.num_nodes(); ++n)
    system.fixed.push_back((options.fix_low_x && lattice.rest_positions(n, 0) <= low[0]) ||
                           random.uniform(0, 1) < options.share_fixed);
  assemble(options, system);
  return system;
}

Cells box_cells(const Vector3i& size) {
  return make_box_lattice(size, Vector3d::Zero(), Vector3d::Ones()).cells;
}

Cells with_holes(const Cells& cells, double share, Random& random) {
  std::vector<int> kept;
  for (int e = 0; e < cells.rows(); ++e)
    if (random.uniform(0, 1) >= share) kept.push_back(e);
  Cells left(kept.size(), 3);
  for (std::size_t i = 0; i < kept.size(); ++i) left.row(Eigen::Index(i)) = cells.row(kept[i]);
  return left;
}

// Layers that slope across the lines along z: a line has cells in some of its vectors, and none between them.
Cells sloping_layers() {
  const Cells box = box_cells({12, 10, 52});
  std::vector<int> kept;
  for (int e = 0; e < int(box.rows()); ++e)
    if ((box(e, 0) + box(e, 1) / 2 + box(e, 2)) % 13 < 3) kept.push_back(e);
  return box(kept, Eigen::all);
}

std::vector<HexSystem> hex_systems() {
  Random random(3);
  Cells islands(6, 3);
  islands << -3, 0, 40, -2, 0, 40, 100, 7, 15, 100, 8, 15, 100, 8, 16, 7, 7, 15;
  std::vector<HexSystem> systems;
  const auto add = [&](const HexSystemOptions& options) { systems.push_back(make_hex_system(options)); };
  add({.name = "a single hex", .cells = box_cells({1, 1, 1}), .turn = 1});
  add({.name = "a block of several bricks",
       .cells = box_cells({10, 9, 18}),
       .turn = 1,
       .multipliers = {1, 10, 300},
       .fix_low_x = true});
  add({.name = "a full brick", .cells = box_cells({8, 8, 16}), .turn = 1});
  add({.name = "holes, flat cells, scattered clamps",
       .cells = with_holes(box_cells({9, 17, 33}), 0.6, random),
       .cell_size = {0.1, 0.03, 0.2},
       .poisson = 0.45,
       .turn = 1,
       .multipliers = {0.5, 2, 20},
       .share_fixed = 0.1});
  add({.name = "islands far apart", .cells = islands, .cell_size = {0.1, 0.2, 0.1}, .poisson = 0, .turn = 1});
  add({.name = "sloping layers", .cells = sloping_layers(), .turn = 1, .multipliers = {1, 30}});
  add({.name = "a rod along x", .cells = box_cells({40, 1, 1}), .turn = 1});
  add({.name = "a rod along z", .cells = box_cells({1, 1, 40}), .poisson = -0.3, .turn = 1});
  return systems;
}

}  // namespace umax::test
