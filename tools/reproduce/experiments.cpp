#include "tools/reproduce/experiments.h"

namespace umax {

const std::vector<Experiment>& experiments() {
  static const std::vector<Experiment> all{
      {"figure1", figure1},         {"figure3", figure3},
      {"figure4", figure4},         {"figure5", figure5},
      {"figure6", figure6},         {"performance", performance},
      {"convergence", convergence}, {"corrections", corrected_equations},
  };
  return all;
}

Variant published_way() {
  return {"published",
          "paper's method and energy",
          {"solver.method=paper", "solver.energy=paper", "solver.jacobian=fixed_rotation", "solver.tolerance=0.01"}};
}

Variant exact_way() {
  return {"exact", "exact method, true energy", {}};
}

std::vector<std::string> joined(std::initializer_list<std::vector<std::string>> settings) {
  std::vector<std::string> all;
  for (const std::vector<std::string>& some : settings) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace umax
