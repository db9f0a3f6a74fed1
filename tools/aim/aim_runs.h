// The runs of a search: what each has of the keys, and what came out of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/aim/aiming.h"
#include "tools/aim/solver.h"
#include "tools/aim/want_reading.h"
#include "tools/setup/body_shape.h"

namespace umax {

struct AimRun {
  std::string name;                   // of its folder: "stretch=13.42%"; "before": the scene as it is
  std::string label;                  // "stretch 13.42 %"
  VectorXd place{};                   // in the ranges; empty: the scene's own values are outside
  std::vector<std::string> values{};  // of the keys; empty: as in the scene
  Scene scene{};
  std::vector<Reading> readings{};  // one of each want
  VectorXd miss{};                  // likewise
  int steps_not_converged = 0;
  bool is_before() const { return values.empty(); }
};

/// Makes runs and reads them. A run that is asked for again is not made again.
class AimRuns {
 public:
  AimRuns(const AimPlan& plan, const AimFolder& folder, const TrialOptions& options, Progress& progress);

  /// The place that the scene's own values have; none where one is outside of its range.
  const std::optional<VectorXd>& start() const { return start_; }

  /// The misses at these places, in order; nothing once a signal came or a run failed: see exit_code().
  std::optional<std::vector<VectorXd>> make(const std::vector<VectorXd>& places);

  const std::vector<AimRun>& all() const { return runs_; }  // the first is the scene as it is
  const AimRun& at(const VectorXd& place) const { return runs_[index_of(place)]; }
  int exit_code() const { return exit_code_; }

 private:
  AimRun run_at(const VectorXd& place) const;
  std::size_t index_of(const VectorXd& place) const;
  bool simulate(std::size_t begin);
  void read(std::size_t begin);
  void tell(std::size_t index) const;

  const AimPlan& plan_;
  const AimFolder& folder_;
  Progress& progress_;
  WorkerOptions workers_;
  std::optional<VectorXd> start_;
  std::vector<AimRun> runs_;
  ShapeLibrary library_{.keeps_cages = true};
  int exit_code_ = 0;
};

/// "height(figure) at 0.6 s = 83.1 % (2.2 % less than wanted)"
std::string reading_text(const Want& want, const Reading& reading);

/// The settings that give the scene the run's values.
std::vector<Override> settings_of(const AimPlan& plan, const AimRun& run);

}  // namespace umax
