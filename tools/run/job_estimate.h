// What a simulation will take, told before it starts: memory and time, from counts alone.
#pragma once

#include <string>
#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

/// What a body's share grows with.
struct BodySize {
  std::string name;
  double hexes = 0, nodes = 0;
  double slots = 0;        // of the bricks that its regular lattice is stored in; a thin one fills few of them
  double vertices = 0;     // of its surface
  bool irregular = false;  // every hex has a shape of its own
};

struct JobSize {
  std::vector<BodySize> bodies;
  bool multigrid = false;      // the linear solver
  bool may_multigrid = false;  // is it, or could it be
};

struct JobEstimate {
  double memory = 0;        // [bytes] at the peak
  double step_seconds = 0;  // [s] a time step, on the average of a clip
};

/// What the scene's text tells, before any cage is made: what it leaves open counts nothing, and where it leaves the
/// solver open, it is the one that needs less.
JobSize size_of(const Scene& scene);
/// The same when these of its bodies have their cages.
JobSize size_of(const Scene& scene, const std::vector<BodySetup>& caged);
JobSize size_of(const Simulation& simulation);

/// [bytes] of the lattice, its hexes' data and the solver.
double lattice_memory(const JobSize& size);

JobEstimate estimate(const JobSize& size);

/// Throws Error (bad_data) with both numbers, and advice, when the job needs more than `memory` [bytes].
void require_memory(const JobSize& size, const Scene& scene, double memory);

/// "about 1.2 GiB of memory and 0:12:00 (150 steps of about 4.8 s) with solver.linear = multigrid"; empty where that is
/// little (up to 1 GiB and 10 minutes) and need not be said.
std::string announce(const JobSize& size, long long steps);

/// More than 1 GiB or 10 minutes [bytes, s].
bool is_worth_saying(double memory, double seconds);

/// "0.54", "4.8", "1187"
std::string seconds_text(double seconds);

}  // namespace umax
