// A box drops on a plane: prints the largest U/U_max of all steps.
#include <algorithm>
#include <cstdio>

#include "core/base/error.h"
#include "core/step/step.h"

namespace {

// a box of 4 x 4 x 4 cells of 10 cm whose surface is the cage's own nodes; no hex of it stores more than 10 % stretch
umax::Body make_box() {
  umax::Body box;
  box.name = "box";
  box.lattice = umax::make_box_lattice({4, 4, 4}, {-0.2, 1, -0.2}, {0.1, 0.1, 0.1});
  box.material.young = 50e3;
  box.limit.kind = umax::LimitKind::hard;
  box.limit.value = 0.1;
  umax::EmbeddedPoints& surface = box.surface;
  surface.hex.resize(8 * box.lattice.num_hexes());
  surface.weights = Eigen::MatrixXd::Zero(surface.hex.size(), 8);
  for (Eigen::Index corner = 0; corner < surface.hex.size(); ++corner) {
    surface.hex[corner] = int(corner / 8);
    surface.weights(corner, corner % 8) = 1;
  }
  return box;
}

}  // namespace

int main() {
  try {
    const umax::Obstacle ground{.name = "ground", .shape = umax::HalfSpace{}, .friction = 0.5};
    const umax::Model model = umax::make_model({make_box()}, {ground});
    umax::Workspace workspace(model);
    umax::State state = umax::rest_state(model);
    double largest = 0;
    int contacts = 0, not_converged = 0;
    for (int i = 0; i < 60; ++i) {
      const umax::StepReport report = umax::step(model, {}, workspace, state);
      largest = std::max(largest, report.max_energy_ratio);
      contacts = std::max(contacts, report.contacts);
      not_converged += report.status != umax::StepStatus::converged;
    }
    // memory that one side takes and the other frees
    umax::Points positions = state.positions;
    positions.conservativeResize(3 * positions.rows(), 3);
    state.positions = std::move(positions);
    std::printf("largest U/U_max %.4f, %d contacts, %d steps not converged\n", largest, contacts, not_converged);
  } catch (const umax::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
