#include "tools/trials/workers.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <list>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "core/base/error.h"
#include "tools/system/signals.h"
#include "tools/system/subprocess.h"

namespace umax {
namespace {

constexpr std::string_view error_start = "umax: error: ", warning_start = "umax: warning: ";
constexpr int wait_ms = 200;  // until we look for a signal again

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0, end; begin < text.size(); begin = end + 1) {
    end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
  }
  return lines;
}

/// An item in hand.
struct Running {
  std::size_t item;
  RunningProcess process;
  Running(std::size_t index, const std::vector<std::string>& command) : item(index), process(command) {}
};

/// The items in hand, and what has come out of them.
class Crew {
 public:
  Crew(const std::vector<WorkItem>& items, const WorkerOptions& options, Progress& progress)
      : items_(items), options_(options), progress_(progress), results_(items.size()) {
    size_ = count_workers(items, options);
  }

  std::vector<WorkResult> work() {
    while (true) {
      const int signal = stop_signal();
      if (signal != 0) pass_on(signal);
      while (signal == 0 && next_ < items_.size() && int(workers_.size()) < size_) begin(next_++);
      if (workers_.empty()) break;
      listen();
    }
    for (; next_ < items_.size(); ++next_) results_[next_] = {exit_code_after(stop_signal()), "not begun"};
    return results_;
  }

 private:
  void begin(std::size_t index) {
    std::vector<std::string> command{options_.program};
    const std::vector<std::string>& words = items_[index].words;
    command.insert(command.end(), words.begin(), words.end());
    command.insert(command.end(), options_.common_words.begin(), options_.common_words.end());
    command.insert(command.end(),
                   {"--progress=json", "--threads", std::to_string(std::max(1, options_.threads / size_))});
    workers_.emplace_back(index, command);
  }

  void pass_on(int signal) {
    if (signalled_) return;
    signalled_ = true;
    for (const Running& worker : workers_) worker.process.send(signal);
  }

  /// Waits for words of any worker, and for the end of those that have said all.
  void listen() {
    std::vector<pollfd> files;
    for (const Running& worker : workers_) files.push_back({worker.process.output(), POLLIN, 0});
    ::poll(files.data(), files.size(), wait_ms);
    for (auto worker = workers_.begin(); worker != workers_.end();) {
      for (const std::string& line : worker->process.new_lines()) hear(items_[worker->item], line);
      if (worker->process.output() >= 0) {
        ++worker;
        continue;
      }
      finish(*worker);
      worker = workers_.erase(worker);
    }
  }

  /// A line of JSON: frames are told, notes are not ours.
  void hear(const WorkItem& item, const std::string& line) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    if (!json.is_object() || json.value("event", "") != "frame") return;
    progress_.frame_done(json.value("frame", 0), item.name + ", " + json.value("stage", ""));
  }

  void finish(Running& worker) {
    WorkResult& result = results_[worker.item];
    result.exit_code = worker.process.wait();
    for (const std::string& line : lines_of(worker.process.messages()))
      if (line.starts_with(error_start))
        result.message = line.substr(error_start.size());
      else if (line.starts_with(warning_start) && warnings_.insert(line).second)
        progress_.warning(items_[worker.item].name + ": " + line.substr(warning_start.size()));
    if (result.exit_code == 0 || stop_signal() != 0) return;
    if (result.message.empty())
      result.message = result.exit_code > 128 ? fmt::format("ended by signal {}", result.exit_code - 128) : "failed";
    progress_.warning(
        fmt::format("{} failed with exit code {}: {}", items_[worker.item].name, result.exit_code, result.message));
  }

  const std::vector<WorkItem>& items_;
  const WorkerOptions& options_;
  Progress& progress_;
  std::vector<WorkResult> results_;
  std::list<Running> workers_;
  std::set<std::string> warnings_;
  std::size_t next_ = 0;
  int size_ = 1;
  bool signalled_ = false;
};

}  // namespace

int count_workers(const std::vector<WorkItem>& items, const WorkerOptions& options) {
  long long largest = 1;
  for (const WorkItem& item : items) largest = std::max(largest, item.memory);
  const long long by_memory = options.memory / largest;
  return int(std::clamp<long long>(std::min<long long>(by_memory, options.threads), 1,
                                   std::max<long long>(1, (long long)(items.size()))));
}

std::vector<WorkResult> run_workers(const std::vector<WorkItem>& items, const WorkerOptions& options,
                                    const std::string& stage, Progress& progress) {
  int frames = 0, done = 0;
  for (const WorkItem& item : items) {
    frames += item.frames;
    done += item.frames_done;
  }
  progress.begin(stage, frames, done);
  std::vector<WorkResult> results = Crew(items, options, progress).work();
  progress.end();
  return results;
}

}  // namespace umax
