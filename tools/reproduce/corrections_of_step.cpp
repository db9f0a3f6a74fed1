// [PPO13] Sect. 5: the step as printed against the program's own, for single hexes held by one face.
#include <fmt/format.h>

#include <algorithm>

#include "core/base/finite_differences.h"
#include "core/step/step.h"
#include "tools/reproduce/correction_samples.h"
#include "tools/reproduce/printed_step.h"

namespace umax {
namespace {

constexpr double time_step = 0.01;  // [s]

StepOptions paper_options() {
  StepOptions options{.time_step = time_step};
  options.solver.method = SolverMethod::paper;
  options.solver.tolerance = 1e-9;
  options.solver.energy = EnergyMeasure::paper;
  options.solver.jacobian = LimitJacobian::fixed_rotation;
  return options;
}

/// The sample's cell at rest, its low-x face held.
Body held_cell(const SampleHex& hex) {
  Body body;
  body.name = "cell";
  const Matrix8x3d& rest = hex.shape.rest_nodes;
  body.lattice = make_box_lattice({1, 1, 1}, rest.row(0), (rest.row(7) - rest.row(0)).transpose());
  body.material = {.young = hex.young, .poisson = hex.shape.poisson, .mass = MassModel::lattice};
  body.fixed_nodes = {0, 1, 2, 3};
  body.surface.weights.resize(0, 8);
  return body;
}

/// Every free node on its way to where the sample has it, in its lattice's frame, within one step.
State thrown(const Model& model, const SampleHex& hex) {
  State state = rest_state(model);
  const Matrix8x3d target = (hex.positions.rowwise() - hex.place.transpose()) * hex.pose;
  for (int n = 0; n < 8; ++n)
    if (!model.node_fixed[model.hexes(0, n)])
      state.velocities.row(model.hexes(0, n)) = (target.row(n) - hex.shape.rest_nodes.row(n)) / time_step;
  return state;
}

Correction unconstrained_step_row() {
  const Correction row{.equation = "19",
                       .printed = "b = (M − h ∂F/∂v) v₀ + h F",
                       .corrected = "the same: it is right; with Rayleigh damping b = M v₀ + h f_el + h M g",
                       .measure = "|v* − the program's v| / |v|, without limits, with damping of mass and stiffness",
                       .remark = "F holds the damping force at v₀, which −h ∂F/∂v v₀ takes out again.",
                       .test = "[PPO13] Eq. 19 is right: the damping force at the start cancels"};
  return measured(row, sample_hexes(), [](const SampleHex& hex) {
    Body cell = held_cell(hex);
    cell.material.damping_mass = 1;
    cell.material.damping_stiffness = 0.01;
    const Model model = make_model({cell}, {});
    State state = thrown(model, hex);
    const Vector24d printed = printed::equation_19(model, paper_options(), state);
    Workspace workspace(model);
    step(model, paper_options(), workspace, state);
    const double error = relative_error(printed, printed::in_hex_order(model, state.velocities));
    return ErrorPair{error, error};
  });
}

/// The cell with a limit [J] that is a share of what it would take in this step without one.
Model limited_cell(const SampleHex& hex, double share) {
  Body cell = held_cell(hex);
  const Model unlimited = make_model({cell}, {});
  const State before = thrown(unlimited, hex);
  const Vector24d end = printed::in_hex_order(unlimited, before.positions) +
                        time_step * printed::equation_19(unlimited, paper_options(), before);
  const CorotatedHex stretched =
      corotate(hex.shape, RotationEstimate::centre, Eigen::Map<const Matrix8x3d>(end.data()));
  const double limit = share * elastic_energy(hex.shape.stiffness_paper, hex.young, stretched);
  cell.limit = {.kind = LimitKind::hard, .unit = LimitUnit::energy, .value = limit};
  return make_model({cell}, {});
}

Correction restart_row(double share, const std::string& name) {
  Correction row{
      .equation = "21, 23",
      .printed = "v = v* + A⁻¹ Jᵀ λ with the total λ, iterated",
      .corrected = "v ← v + A⁻¹ Jᵀ λ: every iteration adds to the last",
      .measure = "U/U_max − 1 after a step of at most 100 iterations; U_max = " + name + " of what U would be without",
      .remark = "",
      .test = "[PPO13] Eq. 21 with the total lambda holds loose limits only, adding to the last iterate holds all"};
  const std::vector<SampleHex> samples = sample_hexes();
  double multiplier = 0;
  row = measured(row, samples, [&](const SampleHex& hex) {
    const Model model = limited_cell(hex, share);
    const State before = thrown(model, hex);
    State after = before;
    Workspace workspace(model);
    const double ratio = step(model, paper_options(), workspace, after).max_energy_ratio;
    multiplier += after.limit_multipliers[0] / energy_limit_at(model, 0, after.time) / double(samples.size());
    const double restarted = printed::equation_21_energy_ratio(model, paper_options(), before);
    return ErrorPair{std::max(0.0, restarted - 1), std::max(0.0, ratio - 1)};
  });
  row.remark = fmt::format(
      "A lacks the curvature of the limits, λ/(h U_max) times that of U. Here it is {:.1f} on average.", multiplier);
  return row;
}

}  // namespace

void add_step_corrections(std::vector<Correction>& rows) {
  rows.push_back(unconstrained_step_row());
  rows.push_back(restart_row(0.5, "1/2"));
  rows.push_back(restart_row(0.1, "1/10"));
  rows.push_back(restart_row(0.01, "1/100"));
}

}  // namespace umax
