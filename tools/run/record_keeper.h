// What is told of a job in its run's folder: run.json and run.log, written while it runs and at its end, however that comes.
#pragma once

#include <functional>
#include <string>

#include "tools/run/job.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_log.h"
#include "tools/run/run_record.h"
#include "tools/system/crash_note.h"

namespace umax {

/// run.json is written at the start, after every stage, at the end and by a crash. Others who share the folder write it
/// too: each adds what is its own.
class RecordKeeper {
 public:
  RecordKeeper(const RunFolder& folder, const RunOptions& options, const std::string& scene_text,
               const Simulation& simulation, RunLog& log);

  /// edit: what is to be changed.
  void change(const std::function<void(RunRecord&)>& edit);
  /// Tells the end and gives the exit status back.
  int finish(int exit_status, const std::string& ended);
  /// The same, where the disk may be what ended it.
  void finish_after_error(int exit_status, const std::string& ended);

 private:
  void tell_start();
  void tell_end(const std::string& ended, const RunRecord& record);
  void prepare_for_crash(const RunRecord& record);

  const RunFolder& folder_;
  const Simulation& simulation_;
  RunLog& log_;
  CrashNote crash_;
  RunRecord own_;             // what all records of this call have in common
  long long first_step_ = 0;  // that was there before
};

}  // namespace umax
