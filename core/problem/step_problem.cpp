#include "core/problem/step_problem.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/contact/clearances.h"
#include "core/contact/surface_overlap.h"
#include "core/model/hex_batches.h"
#include "core/model/hex_limits.h"
#include "core/problem/limit_recovery.h"

namespace umax {
namespace {

constexpr Eigen::Index hexes_per_block = 64;

std::vector<Matrix3d> rotations_at(const Model& model, RotationEstimate estimate, const Points& positions) {
  std::vector<Matrix3d> rotations(std::size_t(model.num_hexes()));
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    evaluate_hexes(model, estimate, positions, begin, end,
                   [&](Eigen::Index e, const HexBatch& batch, int lane) { rotations[e] = rotation_of(batch, lane); });
  });
  return rotations;
}

VectorXd mass_damping(const Model& model, double time) {
  VectorXd damping(model.num_nodes());
  for (const Model::BodyRange& body : model.bodies)
    damping.segment(body.first_node, body.num_nodes).setConstant(body.material.damping_mass.at(time));
  return damping;
}

VectorXd stiffness_damping(const Model& model, double time) {
  VectorXd damping(model.num_hexes());
  for (const Model::BodyRange& body : model.bodies)
    damping.segment(body.first_hex, body.num_hexes).setConstant(body.material.damping_stiffness.at(time));
  return damping;
}

double joining_share_for(double tolerance) {
  return 0.5 * std::min(1.0, tolerance / SolverOptions{}.tolerance);
}

// Bodies may be deep inside each other in the first step, and as long as remembered contacts are.
bool may_start_deep(const ContactStep& contact, const State& state) {
  if (!contact.surfaces_touch || !contact.geometry->touchable.any() || contact.model->bodies.size() < 2) return false;
  if (state.step == 0) return true;
  std::vector<Contact> remembered;
  for (const State::ContactImpulse& memory : state.contacts)
    if (memory.obstacle < 0)
      remembered.push_back(make_surface_contact(*contact.model, memory.point.index, memory.hex, memory.other_hex));
  return are_deep(contact, remembered);
}

}  // namespace

Materials materials_at(const Model& model, double time) {
  Materials materials{VectorXd(model.num_hexes()), VectorXd(Eigen::Index(model.limits.size()))};
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) materials.young[e] = young_at(model, e, time);
  for (std::size_t l = 0; l < model.limits.size(); ++l)
    materials.limits[Eigen::Index(l)] = energy_limit_at(model, model.limits[l].hex, time, model.limits[l].part);
  return materials;
}

StepProblem begin_step(const Model& model, const StepOptions& options, const LinearPlan& plan,
                       const ContactGeometry& geometry, const State& state, std::shared_ptr<Clearances> known) {
  const double h = options.time_step;
  const VectorXd damping_stiffness = stiffness_damping(model, state.time + h);
  const bool damped = (damping_stiffness.array() > 0).any();
  ContactStep contact = begin_contact_step(model, geometry, state.positions, state.positions + h * state.velocities,
                                           state.time, h, options.gravity.norm(), std::move(known));
  contact.surfaces_touch = options.solver.method == SolverMethod::exact;  // the paper has obstacles alone
  if (may_start_deep(contact, state)) contact.deep_start = find_deep_start(contact);
  if (!contact.deep_start.ways_out.empty()) contact.clearances->of_encounters.clear();  // gaps there are of other kinds
  Materials materials = materials_at(model, state.time + h);
  materials.limits = recovering_limits(model, options.solver, state, h, materials);
  StepPins pins = pins_at(model, options.pulls, materials.young, state.time + h, h);
  return {
      .model = &model,
      .options = &options,
      .plan = plan,
      .h = h,
      .positions_t0 = state.positions,
      .velocities_t0 = state.velocities,
      .materials = std::move(materials),
      .damping_mass = mass_damping(model, state.time + h),
      .damping_stiffness = damping_stiffness,
      .rotations_t0 = damped ? rotations_at(model, options.solver.rotation, state.positions) : std::vector<Matrix3d>{},
      .contact = std::move(contact),
      .pins = std::move(pins),
      .joining_share = joining_share_for(options.solver.tolerance)};
}

void require_forces(const Model& model, const Points& forces) {
  if (forces.rows() == 0) return;
  if (forces.rows() != model.num_nodes())
    throw Error(Fault::bad_data, {.where = "forces",
                                  .what = "must have one row for each node of the model",
                                  .value = std::to_string(forces.rows()),
                                  .remedy = "give " + std::to_string(model.num_nodes()) + " rows, or none"});
  if (!forces.allFinite())
    throw Error(Fault::bad_data, {.where = "forces",
                                  .what = "must be finite",
                                  .value = "infinity or NaN",
                                  .remedy = "look at what they are computed from"});
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

VectorXd limit_ratios(const Model& model, const SolverOptions& solver, const Materials& materials,
                      const Points& positions) {
  VectorXd ratios(materials.limits.size());
  parallel_blocks(model.num_hexes(), hexes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    evaluate_hexes(model, solver.rotation, positions, begin, end, [&](Eigen::Index e, const HexBatch& batch, int lane) {
      for (int l = model.limit_starts[e]; l < model.limit_starts[e + 1]; ++l) {
        const HexLimit& limit = model.limits[l];
        const double young = materials.young[e], most = materials.limits[l];
        ratios[l] = bounds_elastic_energy(limit, solver.energy)
                        ? elastic_energy(young, batch, lane) / most
                        : 1 - limit_value(model, solver.energy, limit, young, most, corotated_hex(batch, lane));
      }
    });
  });
  return ratios;
}

}  // namespace umax
