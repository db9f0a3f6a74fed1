#include "core/problem/evaluation.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/hex_batches.h"
#include "core/model/hex_limits.h"
#include "core/problem/step_contacts.h"

namespace umax {
namespace {

constexpr Eigen::Index hexes_per_block = 32;
constexpr Eigen::Index nodes_per_block = 512;
constexpr double negligible_motion = 1e-6;  // [cells] in a step: where nothing acts, rounding must not count

// natural map of the cone complementarity in units of force: 0 iff gap, force and sliding satisfy Signorini and Coulomb
double cone_residual(const StepProblem& problem, const Points& positions, const Contact& contact) {
  const double stiffness = contact_mass(*problem.model, contact) / (problem.h * problem.h);
  const Vector3d force = contact.force;
  const double normal_force = contact.normal.dot(force);
  const double normal = normal_force - std::max(0.0, normal_force - stiffness * contact.gap);
  const Vector3d motion = relative_motion(problem, positions, contact);
  const Vector3d sliding = motion - contact.normal.dot(motion) * contact.normal;
  const Vector3d tangential = force - normal_force * contact.normal;
  const Vector3d friction =
      tangential - project_to_disc(tangential - stiffness * sliding, contact.friction * std::max(0.0, normal_force));
  return std::max(std::abs(normal), friction.cwiseAbs().maxCoeff());
}

// what moves the body's heaviest node by the negligible distance
double negligible_force(const StepProblem& problem, const Model::BodyRange& body) {
  return problem.model->node_mass.segment(body.first_node, body.num_nodes).maxCoeff() * negligible_motion *
         body.cell_size / (problem.h * problem.h);
}

// of a Lagrangian's gradient at a body's free nodes: the largest component of the sum, and of any kind of force
struct LargestForces {
  double sum = 0, of_any_kind = 0;
};

// per body; push: 3 #N [N] of contacts
std::vector<LargestForces> largest_forces(const StepProblem& problem, const Evaluation& evaluation,
                                          const Points& positions, const VectorXd& limit_factors,
                                          const VectorXd& push) {
  const Model& model = *problem.model;
  std::vector<LargestForces> of_bodies;
  for (const Model::BodyRange& body : model.bodies) {
    std::vector<LargestForces> of_blocks(std::size_t((body.num_nodes + nodes_per_block - 1) / nodes_per_block));
    parallel_blocks(body.num_nodes, nodes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
      LargestForces& largest = of_blocks[std::size_t(begin / nodes_per_block)];
      for (Eigen::Index node = body.first_node + begin; node < body.first_node + end; ++node) {
        if (model.node_fixed[node]) continue;
        const Vector3d inertia = inertia_at(problem, positions, node), weight = load_at(problem, node),
                       internal = evaluation.internal.segment<3>(3 * node),
                       limits = limits_at(model, evaluation, limit_factors, node), pushed = push.segment<3>(3 * node);
        largest.sum = std::max(largest.sum, (inertia + internal + limits - pushed).cwiseAbs().maxCoeff());
        for (const Vector3d& force : {Vector3d(inertia + weight), weight, internal, limits, pushed})
          largest.of_any_kind = std::max(largest.of_any_kind, force.cwiseAbs().maxCoeff());
      }
    });
    LargestForces largest{0, negligible_force(problem, body)};
    for (const LargestForces& of_block : of_blocks) {
      largest.sum = std::max(largest.sum, of_block.sum);
      largest.of_any_kind = std::max(largest.of_any_kind, of_block.of_any_kind);
    }
    of_bodies.push_back(largest);
  }
  return of_bodies;
}

VectorXd push_of(const Model& model, const std::vector<Contact>& contacts) {
  VectorXd push = VectorXd::Zero(3 * model.num_nodes());
  for (const Contact& contact : contacts) spread(model, contact, contact.force, push);
  return push;
}

// what the hexes at a node give to it
Vector3d sum_at(const Model& model, const HexColumns& elements, Eigen::Index node) {
  Vector3d sum = Vector3d::Zero();
  for (int i = model.corner_starts[node]; i < model.corner_starts[node + 1]; ++i)
    sum += elements.col(model.corners[i] / 8).segment<3>(3 * (model.corners[i] % 8));
  return sum;
}

// energy and gradient of one limit of a hex whose elastic ones are known
void evaluate_limit(const StepProblem& problem, int l, const HexBatch& batch, int lane, Evaluation& evaluation) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  const HexLimit& limit = model.limits[l];
  const double young = problem.materials.young[limit.hex];
  const bool is_elastic = bounds_elastic_energy(limit, solver.energy);
  const bool own_gradients = evaluation.limit.cols() > 0;
  if (is_elastic) evaluation.energy[l] = evaluation.elastic_energy[limit.hex];
  if (is_elastic && solver.jacobian == LimitJacobian::exact) {
    if (own_gradients) evaluation.limit.col(l) = evaluation.elastic.col(limit.hex);
    return;
  }
  const CorotatedHex hex = corotated_hex(batch, lane);
  if (!is_elastic) evaluation.energy[l] = limited_energy(model, solver.energy, limit, young, hex);
  if (own_gradients)
    evaluation.limit.col(l) =
        limited_gradient(model, solver.energy, solver.jacobian, solver.rotation, limit, young, hex);
}

// beta K(x0) (x - x0)/h of the hexes [begin, end)
void evaluate_damping(const StepProblem& problem, const Points& positions, Eigen::Index begin, Eigen::Index end,
                      HexColumns& damping) {
  const Model& model = *problem.model;
  HexBatch batch;
  for_each_group(model, begin, end, [&](Eigen::Index first, int count) {
    for (int lane = 0; lane < count; ++lane) {
      const Eigen::Index e = first + lane;
      const Matrix8x3d motion = hex_nodes(model, positions, e) - hex_nodes(model, problem.positions_t0, e);
      set_nodes(motion / problem.h, lane, batch);
      set_rotation(problem.rotations_t0[e], lane, batch);
    }
    multiply_warped(model.shapes[model.hex_shape[first]], count, batch);
    for (int lane = 0; lane < count; ++lane) {
      const Eigen::Index e = first + lane;
      damping.col(e) = elastic_gradient(problem.damping_stiffness[e] * problem.materials.young[e], batch, lane);
    }
  });
}

}  // namespace

void evaluate(const StepProblem& problem, const Points& positions, Evaluation& evaluation) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  const bool own_limit_gradients = solver.energy != EnergyMeasure::true_energy ||
                                   solver.jacobian != LimitJacobian::exact || !model.limit_forms.empty();
  const bool damped = !problem.rotations_t0.empty();
  const bool is_assembled = !problem.plan.is_multigrid();
  evaluation.hexes.resize(is_assembled ? model.num_hexes() : 0);
  evaluation.elastic.resize(24, model.num_hexes());
  evaluation.damping.resize(24, damped ? model.num_hexes() : 0);
  evaluation.limit.resize(24, own_limit_gradients ? problem.materials.limits.size() : 0);
  evaluation.elastic_energy.resize(model.num_hexes());
  evaluation.energy.resize(problem.materials.limits.size());
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    const auto keep = [&](Eigen::Index e, const HexBatch& batch, int lane) {
      const double young = problem.materials.young[e];
      evaluation.elastic_energy[e] = elastic_energy(young, batch, lane);
      evaluation.elastic.col(e) = elastic_gradient(young, batch, lane);
      for (int l = model.limit_starts[e]; l < model.limit_starts[e + 1]; ++l)
        evaluate_limit(problem, l, batch, lane, evaluation);
      if (is_assembled) evaluation.hexes[e] = corotated_hex(batch, lane);
    };
    evaluate_hexes(model, solver.rotation, positions, begin, end, keep);
    if (damped) evaluate_damping(problem, positions, begin, end, evaluation.damping);
  });
  evaluation.internal.resize(3 * model.num_nodes());
  parallel_blocks(model.num_nodes(), nodes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index node = begin; node < end; ++node) {
      auto internal = evaluation.internal.segment<3>(3 * node);
      internal = sum_at(model, evaluation.elastic, node);
      if (damped) internal += sum_at(model, evaluation.damping, node);
    }
  });
  add_spring_gradient(model, problem.pins, positions, evaluation.internal);
}

VectorXd gather(const Model& model, const HexColumns& elements) {
  VectorXd nodal = VectorXd::Zero(3 * model.num_nodes());
  if (elements.cols() == 0) return nodal;
  parallel_blocks(model.num_nodes(), nodes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index node = begin; node < end; ++node) nodal.segment<3>(3 * node) = sum_at(model, elements, node);
  });
  return nodal;
}

Vector3d load_at(const StepProblem& problem, Eigen::Index node) {
  const StepOptions& options = *problem.options;
  Vector3d load = problem.model->node_mass[node] * options.gravity;
  if (options.forces.rows() > 0) load += options.forces.row(node).transpose();
  return load;
}

Vector3d inertia_at(const StepProblem& problem, const Points& positions, Eigen::Index node) {
  const StepOptions& options = *problem.options;
  const Vector3d v1 = (positions.row(node) - problem.positions_t0.row(node)).transpose() / problem.h;
  const Vector3d v0 = problem.velocities_t0.row(node).transpose();
  Vector3d demanded =
      problem.model->node_mass[node] * ((v1 - v0) / problem.h + problem.damping_mass[node] * v1 - options.gravity);
  if (options.forces.rows() > 0) demanded -= options.forces.row(node).transpose();
  return demanded;
}

Vector3d limits_at(const Model& model, const Evaluation& evaluation, const VectorXd& factors, Eigen::Index node) {
  Vector3d sum = Vector3d::Zero();
  for (int i = model.corner_starts[node]; i < model.corner_starts[node + 1]; ++i) {
    const int hex = model.corners[i] / 8, n = model.corners[i] % 8;
    for (int l = model.limit_starts[hex]; l < model.limit_starts[hex + 1]; ++l)
      if (factors[l] != 0) sum += factors[l] * evaluation.limit_gradient(model, l).segment<3>(3 * n);
  }
  return sum;
}

double incremental_potential(const StepProblem& problem, const Evaluation& evaluation, const Points& positions) {
  const Model& model = *problem.model;
  const double h = problem.h;
  double sum = 0;
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
    const Vector3d motion = (positions.row(node) - problem.positions_t0.row(node)).transpose();
    const Vector3d unforeseen = motion - h * problem.velocities_t0.row(node).transpose();
    sum += model.node_mass[node] *
           (unforeseen.squaredNorm() / (2 * h * h) + problem.damping_mass[node] * motion.squaredNorm() / (2 * h) -
            problem.options->gravity.dot(motion));
    if (problem.options->forces.rows() > 0) sum -= problem.options->forces.row(node).dot(motion);
  }
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) sum += evaluation.elastic_energy[e];
  for (Eigen::Index e = 0; e < evaluation.damping.cols(); ++e) {
    const Matrix8x3d motion = hex_nodes(model, positions, e) - hex_nodes(model, problem.positions_t0, e);
    sum += 0.5 * evaluation.damping.col(e).dot(Eigen::Map<const Vector24d>(motion.data()));
  }
  return sum + spring_energy(model, problem.pins, positions);
}

VectorXd force_scales(const StepProblem& problem, const Evaluation& evaluation, const Points& positions,
                      const VectorXd& limit_factors, const std::vector<Contact>& contacts) {
  const auto of_bodies =
      largest_forces(problem, evaluation, positions, limit_factors, push_of(*problem.model, contacts));
  VectorXd scales(Eigen::Index(of_bodies.size()));
  for (std::size_t b = 0; b < of_bodies.size(); ++b) scales[Eigen::Index(b)] = of_bodies[b].of_any_kind;
  return scales;
}

double kkt_residual(const StepProblem& problem, const Evaluation& evaluation, const Points& positions,
                    const VectorXd& limit_factors, const std::vector<Contact>& contacts) {
  const auto of_bodies =
      largest_forces(problem, evaluation, positions, limit_factors, push_of(*problem.model, contacts));
  double residual = 0;
  for (const LargestForces& largest : of_bodies) residual = std::max(residual, largest.sum / largest.of_any_kind);
  for (const Contact& contact : contacts) {
    const auto [first, second] = bodies_of(*problem.model, contact);
    double scale = of_bodies[first].of_any_kind;
    if (second >= 0) scale = std::min(scale, of_bodies[second].of_any_kind);
    residual = std::max(residual, cone_residual(problem, positions, contact) / scale);
  }
  return residual;
}

}  // namespace umax
