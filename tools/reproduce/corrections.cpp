#include "tools/reproduce/corrections.h"

#include "tools/reproduce/correction_samples.h"

namespace umax {

std::vector<Correction> corrections() {
  std::vector<Correction> rows;
  add_energy_corrections(rows);
  add_derivative_corrections(rows);
  add_step_corrections(rows);
  return rows;
}

}  // namespace umax
