#include "core/evaluation.h"

#include <algorithm>
#include <cmath>

#include "core/gauss_seidel.h"
#include "core/hex_limits.h"
#include "core/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index hexes_per_block = 32;
constexpr double negligible_motion = 1e-6;  // [cells] in a step: where nothing acts, rounding must not count

double max_norm(const Model& model, const VectorXd& nodal) {
  double largest = 0;
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    if (!model.node_fixed[node]) largest = std::max(largest, nodal.segment<3>(3 * node).cwiseAbs().maxCoeff());
  return largest;
}

// natural map of the cone complementarity in units of force: 0 iff gap, force and sliding satisfy Signorini and Coulomb
double cone_residual(const StepProblem& problem, const Points& positions, const Contact& contact) {
  const double stiffness = contact_mass(*problem.model, contact) / (problem.h * problem.h);
  const Vector3d force = contact.impulse / problem.h;
  const double normal_force = contact.normal.dot(force);
  const double normal = normal_force - std::max(0.0, normal_force - stiffness * contact.gap);
  const Vector3d motion = relative_motion(problem, positions, contact);
  const Vector3d sliding = motion - contact.normal.dot(motion) * contact.normal;
  const Vector3d tangential = force - normal_force * contact.normal;
  const Vector3d friction =
      tangential - project_to_disc(tangential - stiffness * sliding, contact.friction * std::max(0.0, normal_force));
  return std::max(std::abs(normal), friction.cwiseAbs().maxCoeff());
}

// the forces of a Lagrangian's gradient, by kind
struct Forces {
  VectorXd inertia;  // gravity included
  VectorXd gravity, elastic, limit, contact;
};

Forces forces_at(const StepProblem& problem, const Evaluation& evaluation, const Points& positions,
                 const VectorXd& limit_factors, const std::vector<Contact>& contacts) {
  const Model& model = *problem.model;
  Forces forces;
  forces.inertia = inertia_gradient(problem, positions);
  forces.gravity.resize(3 * model.num_nodes());
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node)
    forces.gravity.segment<3>(3 * node) = model.node_mass[node] * problem.options->gravity;
  forces.elastic = gather(model, evaluation.elastic) + gather(model, evaluation.damping);
  forces.limit = VectorXd::Zero(3 * model.num_nodes());
  for (Eigen::Index l = 0; l < limit_factors.size(); ++l)
    if (limit_factors[l] > 0)
      for (int n = 0; n < 8; ++n)
        forces.limit.segment<3>(3 * model.hexes(model.limits[l].hex, n)) +=
            limit_factors[l] * evaluation.limit_gradient(model, l).segment<3>(3 * n);
  forces.contact = VectorXd::Zero(3 * model.num_nodes());
  for (const Contact& c : contacts) spread(model, c, c.impulse / problem.h, forces.contact);
  return forces;
}

// what moves the heaviest node by the negligible distance
double negligible_force(const StepProblem& problem) {
  double largest = 0;
  for (const Model::BodyRange& body : problem.model->bodies)
    largest = std::max(largest, problem.model->node_mass.segment(body.first_node, body.num_nodes).maxCoeff() *
                                    negligible_motion * body.cell_size / (problem.h * problem.h));
  return largest;
}

double largest_of(const StepProblem& problem, const Forces& forces) {
  const Model& model = *problem.model;
  return std::max({max_norm(model, forces.inertia + forces.gravity), max_norm(model, forces.elastic),
                   max_norm(model, forces.limit), max_norm(model, forces.contact), max_norm(model, forces.gravity),
                   negligible_force(problem)});
}

// energy and gradient of one limit of a hex whose elastic ones are known
void evaluate_limit(const StepProblem& problem, int l, const CorotatedHex& hex, Evaluation& evaluation) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  const HexLimit& limit = model.limits[l];
  const double young = problem.young[limit.hex];
  const bool true_whole = limit.form < 0 && solver.energy == EnergyMeasure::true_energy;
  evaluation.energy[l] =
      true_whole ? evaluation.elastic_energy[limit.hex] : limited_energy(model, solver.energy, limit, young, hex);
  if (evaluation.limit.cols() == 0) return;
  if (true_whole && solver.jacobian == LimitJacobian::exact)
    evaluation.limit.col(l) = evaluation.elastic.col(limit.hex);
  else
    evaluation.limit.col(l) =
        limited_gradient(model, solver.energy, solver.jacobian, solver.rotation, limit, young, hex);
}

}  // namespace

void evaluate(const StepProblem& problem, const Points& positions, Evaluation& evaluation) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  const bool own_limit_gradients = solver.energy != EnergyMeasure::true_energy ||
                                   solver.jacobian != LimitJacobian::exact || !model.limit_forms.empty();
  const bool damped = problem.damping_stiffness.size() > 0 && problem.damping_stiffness.maxCoeff() > 0;
  evaluation.hexes.resize(model.num_hexes());
  evaluation.elastic.resize(24, model.num_hexes());
  evaluation.damping.resize(24, damped ? model.num_hexes() : 0);
  evaluation.limit.resize(24, own_limit_gradients ? problem.limits.size() : 0);
  evaluation.elastic_energy.resize(model.num_hexes());
  evaluation.energy.resize(problem.limits.size());
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      const HexShape& shape = model.shapes[model.hex_shape[e]];
      const Matrix8x3d x = hex_nodes(model, positions, e);
      const CorotatedHex hex = corotate(shape, solver.rotation, x);
      const double young = problem.young[e];
      evaluation.elastic_energy[e] = elastic_energy(shape.stiffness, young, hex);
      evaluation.elastic.col(e) =
          exact_gradient(shape.stiffness, young, shape.rotation_gradients[int(solver.rotation)], hex);
      for (int l = model.limit_starts[e]; l < model.limit_starts[e + 1]; ++l)
        evaluate_limit(problem, l, hex, evaluation);
      if (damped) {
        const Matrix8x3d x0 = hex_nodes(model, problem.positions_t0, e);
        const Matrix8x3d velocity = (x - x0) / problem.h;
        evaluation.damping.col(e) = problem.damping_stiffness[e] *
                                    (warped_hessian(shape.stiffness, young, corotate(shape, solver.rotation, x0)) *
                                     Eigen::Map<const Vector24d>(velocity.data()));
      }
      evaluation.hexes[e] = hex;
    }
  });
}

VectorXd gather(const Model& model, const HexColumns& elements) {
  VectorXd nodal = VectorXd::Zero(3 * model.num_nodes());
  for (Eigen::Index e = 0; e < elements.cols(); ++e)
    for (int n = 0; n < 8; ++n) nodal.segment<3>(3 * model.hexes(e, n)) += elements.col(e).segment<3>(3 * n);
  return nodal;
}

VectorXd inertia_gradient(const StepProblem& problem, const Points& positions) {
  const Model& model = *problem.model;
  VectorXd gradient(3 * model.num_nodes());
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
    const Vector3d v1 = (positions.row(node) - problem.positions_t0.row(node)).transpose() / problem.h;
    const Vector3d v0 = problem.velocities_t0.row(node).transpose();
    gradient.segment<3>(3 * node) =
        model.node_mass[node] * ((v1 - v0) / problem.h + problem.damping_mass[node] * v1 - problem.options->gravity);
  }
  return gradient;
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
  }
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) sum += evaluation.elastic_energy[e];
  for (Eigen::Index e = 0; e < evaluation.damping.cols(); ++e) {
    const Matrix8x3d motion = hex_nodes(model, positions, e) - hex_nodes(model, problem.positions_t0, e);
    sum += 0.5 * evaluation.damping.col(e).dot(Eigen::Map<const Vector24d>(motion.data()));
  }
  return sum;
}

double force_scale(const StepProblem& problem, const Evaluation& evaluation, const Points& positions,
                   const VectorXd& limit_factors, const std::vector<Contact>& contacts) {
  return largest_of(problem, forces_at(problem, evaluation, positions, limit_factors, contacts));
}

double kkt_residual(const StepProblem& problem, const Evaluation& evaluation, const Points& positions,
                    const VectorXd& limit_factors, const std::vector<Contact>& contacts) {
  double cone = 0;
  for (const Contact& contact : contacts) cone = std::max(cone, cone_residual(problem, positions, contact));
  const Forces forces = forces_at(problem, evaluation, positions, limit_factors, contacts);
  const VectorXd sum = forces.inertia + forces.elastic + forces.limit - forces.contact;
  return std::max(max_norm(*problem.model, sum), cone) / largest_of(problem, forces);
}

}  // namespace umax
