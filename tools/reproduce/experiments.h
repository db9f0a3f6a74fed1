// The paper's experiments, in its order. Each simulates what it needs and says what came out.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "tools/reproduce/report.h"
#include "tools/reproduce/workbench.h"

namespace umax {

ReportSection figure1(Workbench& bench);
ReportSection figure3(Workbench& bench);
ReportSection figure4(Workbench& bench);
ReportSection figure5(Workbench& bench);
ReportSection figure6(Workbench& bench);
ReportSection performance(Workbench& bench);
ReportSection convergence(Workbench& bench);
ReportSection corrected_equations(Workbench& bench);

struct Experiment {
  const char* name;
  ReportSection (*run)(Workbench&);
};
const std::vector<Experiment>& experiments();

/// Settings of a scene that an experiment compares: materials, or ways to solve a step.
struct Variant {
  std::string name;   // in folders' names
  std::string label;  // in tables and pictures
  std::vector<std::string> settings;
};

/// Solved as the paper does: its method, its energy inside the limits, its derivative of them, held to 1 %.
Variant published_way();
/// The program's own: exact minimiser, true energy, limits held to 0.1 %.
Variant exact_way();

/// Settings one after the other; of two for the same key the last one counts.
std::vector<std::string> joined(std::initializer_list<std::vector<std::string>> settings);

}  // namespace umax
