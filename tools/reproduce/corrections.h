// The equations of [PPO13] that are wrong as printed: each with its error as printed and as corrected, computed afresh.
#pragma once

#include <string>
#include <vector>

namespace umax {

struct Correction {
  std::string equation;        // its number or section in [PPO13]
  std::string printed;         // what stands there
  std::string corrected;       // what belongs there
  std::string measure;         // what the errors are, relative to what
  std::string remark;          // why, or when it does not matter
  std::string test;            // name of the test that proves it
  int num_samples = 0;         // that the errors were taken over
  double error_printed = 0;    // [-] mean
  double lowest_printed = 0;   // [-]
  double highest_printed = 0;  // [-]
  double error_corrected = 0;  // [-] the largest
};

/// In the order of the equations. Deterministic; takes well under a second.
std::vector<Correction> corrections();

}  // namespace umax
