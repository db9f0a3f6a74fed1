// run.log: what every call did in a run's folder, for whoever looks for what went wrong. Lines of text that are appended,
// each with its time and its process, so that several who share the folder can tell theirs apart.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "tools/run/steps_csv.h"
#include "tools/system/progress.h"

namespace umax {

/// The log of one call. Until it is opened, as long as the folder is not ours yet, it keeps its lines. A line that cannot be
/// written is lost: a full disk shall not end what it might not have ended.
class RunLog {
 public:
  /// Listens to what progress is told, as long as it lives.
  explicit RunLog(Progress& progress);
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  void open(const std::filesystem::path& path);
  void write(const std::string& line);
  /// How often which warning came; nothing when none did.
  void write_warnings();
  /// The line as it would be written now.
  std::string stamped(const std::string& line) const;

 private:
  void append(const std::string& text) const;

  Progress& progress_;
  std::string writer_;                   // "host:process"
  std::vector<std::string> kept_;        // stamped, not written yet
  std::map<std::string, int> warnings_;  // how often, without their numbers
  std::map<std::string, std::string> first_of_kind_;
  int file_ = -1;
};

/// "2026-11-26T19:20:03Z", of now.
std::string utc_time();

/// The command that runs this program, as /proc tells it.
std::string command_text();

/// The slowest of the steps after `first`, at most `count`, each in a line with what it had more of than is usual.
std::vector<std::string> slowest_steps(const StepsFound& steps, long long first, int count);

}  // namespace umax
