#include "tools/tune/measures.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "tools/pictures/heat.h"
#include "tools/pictures/shot.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace {

double largest_of(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

/// [J] the energy of all hexes stretched to twice their length.
double energy_scale(const Model& model, double time) {
  double sum = 0;
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e)
    sum += 0.5 * young_at(model, e, time) * model.shapes[model.hex_shape[e]].volume;
  return sum;
}

/// [m] of each body's surface.
std::vector<double> heights(const Simulation& simulation, const Points& nodes, Box& box) {
  std::vector<double> result;
  for (const BodySetup& body : simulation.bodies) {
    const Box own = box_of(body, nodes);
    box.extend(own);
    result.push_back(own.sizes().y());
  }
  return result;
}

/// What is read off one state.
struct FrameMeasures {
  double time = 0;
  std::vector<double> heights;  // [m] of the bodies
  Box box;
  HeatRange range;
};

/// Of all states of the run, read side by side.
std::vector<FrameMeasures> read_frames(const Simulation& simulation, const std::filesystem::path& run) {
  std::vector<FrameMeasures> frames(std::size_t(simulation.last_frame()));
  parallel_blocks(simulation.last_frame(), 1, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const State state = read_state(state_path(run, int(i) + 1), simulation.model, simulation.digest);
      FrameMeasures& frame = frames[std::size_t(i)];
      frame.time = state.time;
      frame.heights = heights(simulation, state.positions, frame.box);
      extend(frame.range, simulation, state);
    }
  });
  return frames;
}

void measure_frames(const Simulation& simulation, const std::filesystem::path& run, VariantMeasures& measures) {
  const std::vector<FrameMeasures> frames = read_frames(simulation, run);
  const std::vector<double>& at_start = frames.front().heights;
  std::size_t lowest = 0;
  const int substeps = simulation.scene.clip.substeps;
  const std::vector<double>& energy = measures.steps.columns.at("elastic_energy_J");
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const FrameMeasures& frame = frames[k];
    for (std::size_t i = 0; i < frame.heights.size(); ++i)
      if (k == 0 || frame.heights[i] / at_start[i] < measures.least_share) {
        measures.least_share = frame.heights[i] / at_start[i];
        measures.least_height = frame.heights[i];
        lowest = i;
      }
    measures.box.extend(frame.box);
    measures.largest_stretch = std::max(measures.largest_stretch, frame.range.largest);
    const std::size_t row = k * std::size_t(substeps);
    const double elastic = row == 0 || row > energy.size() ? 0 : energy[row - 1];
    measures.stretch.push_back(std::sqrt(std::max(elastic, 0.0) / energy_scale(simulation.model, frame.time)));
  }
  Box placed;
  const double height = heights(simulation, simulation.model.rest_positions, placed)[lowest];
  measures.lowest_body = simulation.bodies[lowest].name;
  for (const FrameMeasures& frame : frames) measures.shares.push_back(frame.heights[lowest] / height);
}

}  // namespace

VariantMeasures measure(const Scene& scene, const std::filesystem::path& run, ShapeLibrary& library) {
  Scene stretch_of = scene;
  stretch_of.render.heatmap = Heatmap::stretch;
  const Simulation simulation = set_up(stretch_of, library);
  VariantMeasures measures;
  measures.hexes = int(simulation.model.num_hexes());
  measures.steps = read_steps(run / "steps.csv", steps_header(probe_names(scene)));
  measures.largest_ratio = largest_of(measures.steps.columns.at("max_energy_ratio"));
  measures.most_limits = int(largest_of(measures.steps.columns.at("limits_active")));
  measures.steps_not_converged =
      int(std::count(measures.steps.converged.begin(), measures.steps.converged.end(), false));
  measure_frames(simulation, run, measures);
  return measures;
}

int worst_frame(const std::vector<VariantMeasures>& measures) {
  int worst = 1;
  double largest = -1;
  std::size_t frames = 0;  // a variant that failed has none
  for (const VariantMeasures& variant : measures) frames = std::max(frames, variant.stretch.size());
  for (std::size_t frame = 0; frame < frames; ++frame) {
    double sum = 0;
    for (const VariantMeasures& variant : measures) sum += frame < variant.stretch.size() ? variant.stretch[frame] : 0;
    if (sum > largest) {
      largest = sum;
      worst = int(frame) + 1;
    }
  }
  return worst;
}

}  // namespace umax
