// steps.csv: one row per time step, in a fixed order of columns; cut back to the last complete state when a run goes
// on.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/step/step.h"

namespace umax {

struct StepRow {
  long long step = 0;  // from 1
  int frame = 0;       // that the step leads to
  double time = 0;     // [s] at its end
  long long hexes = 0;
  StepReport report;
  double wall_ms = 0;
  std::vector<Vector3d> probes;  // [m] in the order of the header's names
};

/// The header row: the columns of every run, three for each probe, and what came later. No line end.
std::string steps_header(const std::vector<std::string>& probes);
std::string format_step(const StepRow& row);
const char* status_name(StepStatus status);

/// What is on disk: whole rows that follow one another from step 1.
struct StepsFound {
  long long rows = 0;
  std::vector<bool> converged;                         // one per row
  std::map<std::string, std::vector<double>> columns;  // numbers by the header's names, one per row; status is NaN
};
/// Throws Error (bad_data) when the file has another header; a file that is not there has no rows.
StepsFound read_steps(const std::filesystem::path& path, const std::string& header);

/// Appends rows to a file that keeps its first `rows` rows; whole groups of rows only.
class StepsFile {
 public:
  StepsFile(const std::filesystem::path& path, const std::string& header, long long rows);
  ~StepsFile();
  StepsFile(const StepsFile&) = delete;
  StepsFile& operator=(const StepsFile&) = delete;

  /// On disk when it returns. Throws Error (io_error) and leaves the file as it was.
  void append(const std::vector<StepRow>& rows);

 private:
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace umax
