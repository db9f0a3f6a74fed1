#include "tools/run/record_keeper.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "core/files/sha256.h"
#include "scenes/resolved_scene.h"
#include "tools/run/steps_csv.h"
#include "tools/system/machine_memory.h"
#include "tools/system/seconds_since.h"
#include "tools/system/version.h"

namespace umax {
namespace {

constexpr int slowest_told = 5;
constexpr std::size_t longest_setting = 160;  // [characters] of a line; keyed values can be long

std::string system_text() {
  utsname system{};
  return uname(&system) == 0 ? fmt::format("{} {}", system.sysname, system.release) : "unknown system";
}

/// The lines of a text, with something else in between.
std::string in_one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) text.replace(at, 1, "; ");
  return text;
}

std::string shortened(const std::string& text) {
  return text.size() <= longest_setting ? text : text.substr(0, longest_setting) + "…";
}

}  // namespace

RecordKeeper::RecordKeeper(const RunFolder& folder, const RunOptions& options, const std::string& scene_text,
                           const Simulation& simulation, RunLog& log)
    : folder_(folder), simulation_(simulation), log_(log) {
  own_.version = version_text();
  own_.verb = options.verb;
  own_.scene = simulation.scene.name;
  own_.scene_sha256 = sha256_hex(scene_text);
  own_.model_sha256 = simulation.digest;
  own_.host = host_description();
  own_.threads = options.threads;
  own_.caller = describe(this_worker(""));
  own_.began = utc_time();
  tell_start();
  change([&](RunRecord& record) {
    first_step_ = record.steps;
    record.exit_status.reset();
    record.ended.clear();
  });
  log_.open(folder.log());
}

void RecordKeeper::tell_start() {
  const auto before = read_run_record(folder_.record());
  if (before && !before->exit_status) {
    const std::string ended = how_it_ended(*before, folder_.presence().others());
    own_.calls_killed = ended.starts_with(without_a_word) ? 1 : 0;
    if (own_.calls_killed > 0) log_.write("the call before ended " + ended);
  }
  log_.write(in_one_line(version_report()));
  log_.write(fmt::format("machine: {}, {}, {} threads used, {} of memory to be had", own_.host, system_text(),
                         own_.threads, format_memory(double(available_memory()))));
  log_.write(fmt::format("scene {}: sha256 {}", own_.scene, own_.scene_sha256));
  for (const std::string& setting : changed_settings(simulation_.scene)) log_.write("setting " + shortened(setting));
}

void RecordKeeper::change(const std::function<void(RunRecord&)>& edit) {
  // the others are done in a moment; should one be stuck, its share is lost rather than ours
  const auto start = std::chrono::steady_clock::now();
  const bool is_ours = folder_.presence().claim_when_free("record", [&] { return seconds_since(start) > 20; });
  const RunRecord before = read_run_record(folder_.record()).value_or(RunRecord{});
  RunRecord record = own_;
  record.frames = before.frames;
  record.steps = before.steps;
  record.steps_not_converged = before.steps_not_converged;
  record.simulate_seconds = before.simulate_seconds;
  record.render_seconds = before.render_seconds;
  record.encode_seconds = before.encode_seconds;
  record.instruction_set = before.instruction_set;
  record.exit_status = before.exit_status;
  record.ended = before.ended;
  record.calls_killed = before.calls_killed + std::exchange(own_.calls_killed, 0);
  record.peak_memory = std::max(before.peak_memory, peak_memory());
  edit(record);
  write_run_record(folder_.record(), record);
  prepare_for_crash(record);
  if (is_ours) folder_.presence().release("record");
}

void RecordKeeper::prepare_for_crash(const RunRecord& record) {
  // others who share the folder go on: theirs is the record then
  const bool is_alone = folder_.presence().others().empty();
  crash_.prepare([&](int signal) {
    RunRecord crashed = record;
    crashed.exit_status = 128 + signal;
    crashed.ended = fmt::format("crashed by {}", signal_name(signal));
    std::vector<CrashText> texts{{folder_.log(), log_.stamped(crashed.ended), true}};
    if (is_alone) texts.push_back({folder_.record(), run_record_text(crashed)});
    return texts;
  });
}

int RecordKeeper::finish(int exit_status, const std::string& ended) {
  const bool is_last = folder_.presence().others().empty();
  change([&](RunRecord& record) {
    if (is_last || exit_status != 0) {
      record.exit_status = exit_status;
      record.ended = ended;
    }
    tell_end(fmt::format("{}; exit status {}", ended, exit_status), record);
  });
  return exit_status;
}

void RecordKeeper::finish_after_error(int exit_status, const std::string& ended) {
  try {
    finish(exit_status, ended);
  } catch (const Error&) {  // NOLINT(bugprone-empty-catch): as the line below says
    // the disk that refuses this refused something before: that is what the user is told
  }
}

void RecordKeeper::tell_end(const std::string& ended, const RunRecord& record) {
  try {
    const StepsFound steps = read_steps(folder_.steps(), steps_header(probe_names(simulation_.scene)));
    for (const std::string& line : slowest_steps(steps, first_step_, slowest_told)) log_.write(line);
  } catch (const Error&) {  // NOLINT(bugprone-empty-catch): as the line below says
    // steps of another version, or a folder that is gone: the end is told all the same
  }
  log_.write_warnings();
  log_.write(
      fmt::format("{} frames, {} steps, {} of them not converged; {:.1f} s simulated, {:.1f} s rendered, {:.1f} s "
                  "encoded, all calls together; peak memory {}",
                  record.frames, record.steps, record.steps_not_converged, record.simulate_seconds,
                  record.render_seconds, record.encode_seconds, format_memory(double(record.peak_memory))));
  log_.write("ended " + ended);
}

}  // namespace umax
