// A run's surfaces for the measure of penetration, which is not the contact's: tests/support/penetration.h.
#pragma once

#include <vector>

#include "core/step/step.h"
#include "tests/support/penetration.h"
#include "tools/benchmarks/bench.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

/// The run's bodies, to be measured in any number of its states.
std::vector<test::MeasuredBody> measured_bodies(const Simulation& simulation);

/// What a run's states were measured to be at their worst, and what measuring took.
struct WorstPenetration {
  test::PenetrationReport worst;  // deepest of all states; sums of counts
  int states = 0;
  double seconds = 0;  // of all measurements
};
void measure(const Simulation& simulation, const std::vector<test::MeasuredBody>& bodies, const State& state,
             WorstPenetration& worst);

/// Rows of the deepest point and the deepest crossing, against what was asked for.
void append_penetration(const std::string& what, const WorstPenetration& worst, BenchRows& rows);

}  // namespace umax
