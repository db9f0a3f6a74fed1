#include "core/step_problem.h"

#include <algorithm>
#include <cmath>

#include "core/gauss_seidel.h"
#include "core/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index hexes_per_block = 64;

using HexColumns = Eigen::Matrix<double, 24, Eigen::Dynamic>;

// per hex: elastic + stiffness-damping gradient, and limit gradient scaled by its multiplier
struct ElementGradients {
  HexColumns elastic, limit;
};

ElementGradients element_gradients(const StepProblem& problem, const Points& positions, const VectorXd& multipliers) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  ElementGradients gradients{HexColumns(24, model.num_hexes()), HexColumns(24, model.num_hexes())};
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const Matrix8x3d x = hex_nodes(model, positions, e);
      const CorotatedHex hex = corotate(shape, solver.rotation, x);
      gradients.elastic.col(e) =
          exact_gradient(shape.stiffness, problem.young[e], shape.rotation_gradients[int(solver.rotation)], hex);
      if (problem.damping_stiffness[e] > 0) {
        const Matrix8x3d x0 = hex_nodes(model, problem.positions_t0, e);
        const CorotatedHex hex0 = corotate(shape, solver.rotation, x0);
        const Matrix8x3d velocity = (x - x0) / problem.h;
        const Vector24d v = Eigen::Map<const Vector24d>(velocity.data());
        gradients.elastic.col(e) +=
            problem.damping_stiffness[e] * (warped_hessian(shape.stiffness, problem.young[e], hex0) * v);
      }
      if (multipliers[e] > 0)
        gradients.limit.col(e) =
            -multipliers[e] * energy_limit_jacobian(shape, solver.energy, solver.jacobian, solver.rotation,
                                                    problem.young[e], problem.limits[e], hex);
      else
        gradients.limit.col(e).setZero();
    }
  });
  return gradients;
}

VectorXd gather(const Model& model, const HexColumns& elements) {
  VectorXd nodal = VectorXd::Zero(3 * model.num_nodes());
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    for (int n = 0; n < 8; ++n) nodal.segment<3>(3 * model.hexes(e, n)) += elements.col(e).segment<3>(3 * n);
  return nodal;
}

double max_norm(const Model& model, const VectorXd& nodal) {
  double largest = 0;
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    if (!model.node_fixed[node]) largest = std::max(largest, nodal.segment<3>(3 * node).cwiseAbs().maxCoeff());
  return largest;
}

// natural map of the cone complementarity in units of force: 0 iff gap, force and sliding satisfy Signorini and Coulomb
double cone_residual(const StepProblem& problem, const Points& positions, const Contact& contact) {
  const Model& model = *problem.model;
  double mass = 0;
  for (int n = 0; n < 8; ++n) mass += contact.weights[n] * model.node_mass[model.hexes(contact.hex, n)];
  const double stiffness = mass / (problem.h * problem.h);
  const Vector3d force = contact.impulse / problem.h;
  const double normal_force = contact.normal.dot(force);
  const double normal = normal_force - std::max(0.0, normal_force - stiffness * contact.gap);
  const Vector3d motion = embedded_position(model, positions, contact.hex, contact.weights) -
                          embedded_position(model, problem.positions_t0, contact.hex, contact.weights) -
                          contact.obstacle_motion;
  const Vector3d sliding = motion - contact.normal.dot(motion) * contact.normal;
  const Vector3d tangential = force - normal_force * contact.normal;
  const Vector3d friction =
      tangential - project_to_disc(tangential - stiffness * sliding, contact.friction * std::max(0.0, normal_force));
  return std::max(std::abs(normal), friction.cwiseAbs().maxCoeff());
}

}  // namespace

StepProblem begin_step(const Model& model, const StepOptions& options, const ContactGeometry& geometry,
                       const State& state) {
  StepProblem problem;
  problem.model = &model;
  problem.options = &options;
  problem.h = options.time_step;
  problem.positions_t0 = state.positions;
  problem.velocities_t0 = state.velocities;
  problem.young.resize(model.num_hexes());
  problem.limits.resize(model.num_hexes());
  problem.damping_stiffness.resize(model.num_hexes());
  problem.damping_mass.resize(model.num_nodes());
  const double time_t1 = state.time + options.time_step;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    problem.young[e] = young_at(model, e, time_t1);
    problem.limits[e] = energy_limit_at(model, e, time_t1);
    problem.damping_stiffness[e] = model.bodies[model.hex_body[e]].material.damping_stiffness;
  }
  for (const Model::BodyRange& body : model.bodies)
    problem.damping_mass.segment(body.first_node, body.num_nodes).setConstant(body.material.damping_mass);
  problem.contact =
      begin_contact_step(model, geometry, state.positions, state.time, options.time_step, options.gravity.norm());
  return problem;
}

VectorXd flatten(const Points& points) {
  return Eigen::Map<const VectorXd>(points.data(), points.size());
}

Points unflatten(const VectorXd& vector) {
  return Eigen::Map<const Points>(vector.data(), vector.size() / 3, 3);
}

void clear_fixed(const Model& model, Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) {
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    if (model.node_fixed[node]) columns.middleRows<3>(3 * node).setZero();
}

VectorXd energy_ratios(const StepProblem& problem, const Points& positions) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  VectorXd ratios = VectorXd::Zero(model.num_hexes());
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      if (!std::isfinite(problem.limits[e])) continue;
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const CorotatedHex hex = corotate(shape, solver.rotation, hex_nodes(model, positions, e));
      ratios[e] = 1 - energy_limit_value(shape, solver.energy, problem.young[e], problem.limits[e], hex);
    }
  });
  return ratios;
}

double kkt_residual(const StepProblem& problem, const Points& positions_t1, const VectorXd& multipliers,
                    const std::vector<Contact>& contacts) {
  const Model& model = *problem.model;
  const ElementGradients gradients = element_gradients(problem, positions_t1, multipliers);
  VectorXd inertia(3 * model.num_nodes()), gravity(3 * model.num_nodes());
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
    const Vector3d v1 = (positions_t1.row(node) - problem.positions_t0.row(node)).transpose() / problem.h;
    const Vector3d v0 = problem.velocities_t0.row(node).transpose();
    inertia.segment<3>(3 * node) = model.node_mass[node] * ((v1 - v0) / problem.h + problem.damping_mass[node] * v1);
    gravity.segment<3>(3 * node) = model.node_mass[node] * problem.options->gravity;
  }
  VectorXd contact = VectorXd::Zero(3 * model.num_nodes());
  double cone = 0;
  for (const Contact& c : contacts) {
    spread(model, c, c.impulse / problem.h, contact);
    cone = std::max(cone, cone_residual(problem, positions_t1, c));
  }
  const VectorXd elastic = gather(model, gradients.elastic), limit = gather(model, gradients.limit);
  const double scale = std::max({max_norm(model, inertia), max_norm(model, elastic), max_norm(model, limit),
                                 max_norm(model, contact), max_norm(model, gravity)});
  if (!(scale > 0)) return 0;
  return std::max(max_norm(model, inertia + elastic + limit - contact - gravity), cone) / scale;
}

void spread(const Model& model, const Contact& contact, const Vector3d& force, Eigen::Ref<VectorXd> nodal) {
  for (int n = 0; n < 8; ++n) nodal.segment<3>(3 * model.hexes(contact.hex, n)) += contact.weights[n] * force;
}

void remember_contacts(const std::vector<Contact>& contacts, State& state) {
  state.contacts.clear();
  for (const Contact& contact : contacts)
    if (contact.impulse.squaredNorm() > 0)
      state.contacts.push_back({contact.point, contact.obstacle, contact.hex, contact.impulse});
}

std::vector<Contact> recall_contacts(const StepProblem& problem, const State& state, const Points& positions) {
  const Model& model = *problem.model;
  std::vector<Contact> contacts;
  for (const State::ContactImpulse& memory : state.contacts) {
    Contact contact;
    contact.point = memory.point;
    contact.obstacle = memory.obstacle;
    contact.hex = memory.hex;
    contact.impulse = memory.impulse;
    contact.friction =
        std::max(model.bodies[model.hex_body[memory.hex]].friction, model.obstacles[memory.obstacle].friction);
    contact.weights =
        memory.point >= 0 ? Vector8d(model.surface.weights.row(memory.point).transpose()) : Vector8d::Constant(0.125);
    contacts.push_back(contact);
  }
  update_contacts(problem.contact, positions, contacts);
  return contacts;
}

}  // namespace umax
