// What is read off a variant's run, to be compared with the others.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/run/steps_csv.h"
#include "tools/setup/body_shape.h"
#include "tools/setup/camera_framing.h"

namespace umax {

struct VariantMeasures {
  StepsFound steps;
  int hexes = 0;
  std::vector<double> stretch;  // [-] one a frame: sqrt(2 U / integral of Y dV) with the elastic energy U of all
                                // bodies: what the bodies are stretched by on the whole
  double largest_ratio = 0;     // U/U_max of any hex, after any step
  double largest_stretch = 0;   // [%] of any hex in any frame: sqrt(2 U/(Y V))
  double least_height = 0;      // [m] of the body that loses the largest share of its height in any frame
  double least_share = 1;       // [-] that is left of that body's height at the start
  std::string lowest_body;      // its name
  std::vector<double> shares;   // [-] of its height as it is placed, one a frame
  int most_limits = 0;          // active after a step
  int steps_not_converged = 0;
  double wall_seconds = 0;  // that its run took, simulation and pictures
  Box box;                  // around all surfaces in all frames
};

/// Measures a whole run of this scene; what the library knows of other variants is not made again. Throws Error as reading
/// it does.
VariantMeasures measure(const Scene& scene, const std::filesystem::path& run, ShapeLibrary& library);

/// The frame, from 1, at which the variants are stretched most: the largest sum of their measures' `stretch`.
int worst_frame(const std::vector<VariantMeasures>& measures);

}  // namespace umax
