// What an experiment works with: it asks for runs and pictures, and they are made unless they are there already.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/annotation/annotate.h"
#include "tools/reproduce/report_folder.h"
#include "tools/run/job.h"
#include "tools/run/steps_csv.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

/// Thrown when a signal asks us to stop: what is finished is kept.
struct Interrupted {
  int signal = 0;
};

/// A simulated clip. Frame 1 is the initial state.
struct Run {
  std::shared_ptr<const Simulation> simulation;
  std::filesystem::path folder;
  StepsFound steps;

  int num_frames() const { return simulation->last_frame(); }
  double time_of(int frame) const { return (frame - 1) / simulation->scene.clip.fps; }  // [s]
  State state(int frame) const;
  /// A column of steps.csv, one value a step.
  const std::vector<double>& column(const std::string& name) const { return steps.columns.at(name); }
};

/// Words on a tile; x and y in [0, 1] from the top left.
struct TileNote {
  std::string text;
  double x = 0, y = 0;
};

/// A picture to be path-traced.
struct Tile {
  std::string label;  // below it
  std::string key;    // of all that decides it but size, samples and words
  std::function<RenderScene(double aspect)> shot;
  std::vector<TileNote> notes{};
};

struct SheetSize {
  int width = 480, height = 360;  // [px] of a tile
  int columns = 3;
  int samples = 128;  // paths a pixel
};

/// How a report is made.
struct ReportOptions {
  bool quick = false;                       // small pictures of few samples
  std::optional<int> samples = {};          // paths a pixel; none: what the picture and `quick` want
  std::vector<std::string> armadillo = {};  // settings that place it: see armadillo_settings_of()
  RunOptions run = {};                      // of each simulation
};

class Workbench {
 public:
  Workbench(ReportFolder& folder, const ReportOptions& options, Progress& progress);

  bool quick() const { return options_.quick; }
  ReportFolder& folder() { return folder_; }

  /// A built-in scene with settings ("body.beam.limit.energy=1 J"), simulated into the folder runs/NAME. Throws
  /// Interrupted, and Error as a run does.
  Run simulate(const std::string& name, const std::string& scene, const std::vector<std::string>& settings);

  /// The armadillo's file when --set body.armadillo.mesh names one: then scene "armadillo", else "figure".
  bool has_armadillo() const { return !options_.armadillo.empty(); }
  const std::vector<std::string>& armadillo_settings() const { return options_.armadillo; }

  /// Traces the tiles that are not there yet and puts them side by side into NAME.png, smaller and coarser with
  /// --quick. Throws Interrupted.
  std::filesystem::path sheet(const std::string& name, const std::vector<Tile>& tiles, const SheetSize& size);

 private:
  std::filesystem::path paint(const std::string& name, const Tile& tile, const RenderDescription& render);

  ReportFolder& folder_;
  ReportOptions options_;
  Progress& progress_;
};

/// What the settings of --set say of the armadillo's file; none when they give no file. Throws Error (usage) for other
/// keys: everything else the paper prescribes.
std::vector<std::string> armadillo_settings_of(const std::vector<std::string>& settings);

/// A run's frame with the camera, lights and sky of its scene.
Tile tile_of(const Run& run, int frame, const std::string& label);

}  // namespace umax
