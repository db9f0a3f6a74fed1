#include "tools/run/run_record.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"

namespace umax {
namespace {

nlohmann::ordered_json to_json(const RunRecord& record) {
  nlohmann::ordered_json json;
  json["program"] = "umax";
  json["version"] = record.version;
  json["verb"] = record.verb;
  json["scene"] = record.scene;
  json["scene_sha256"] = record.scene_sha256;
  json["model_sha256"] = record.model_sha256;
  json["host"] = record.host;
  json["threads"] = record.threads;
  json["instruction_set"] = record.instruction_set;
  json["caller"] = record.caller;
  json["began"] = record.began;
  json["totals"] = {{"seconds", record.seconds()},
                    {"simulate_seconds", record.simulate_seconds},
                    {"render_seconds", record.render_seconds},
                    {"encode_seconds", record.encode_seconds},
                    {"frames", record.frames},
                    {"steps", record.steps},
                    {"peak_memory_bytes", record.peak_memory}};
  json["steps_not_converged"] = record.steps_not_converged;
  if (record.exit_status)
    json["exit_status"] = *record.exit_status;
  else
    json["exit_status"] = nullptr;
  if (record.ended.empty())
    json["ended"] = nullptr;
  else
    json["ended"] = record.ended;
  json["calls_killed"] = record.calls_killed;
  return json;
}

RunRecord from_json(const nlohmann::json& json) {
  RunRecord record;
  record.version = json.at("version");
  record.verb = json.at("verb");
  record.scene = json.at("scene");
  record.scene_sha256 = json.at("scene_sha256");
  record.model_sha256 = json.at("model_sha256");
  record.host = json.at("host");
  record.threads = json.at("threads");
  const auto& totals = json.at("totals");
  record.simulate_seconds = totals.at("simulate_seconds");
  record.render_seconds = totals.at("render_seconds");
  record.encode_seconds = totals.at("encode_seconds");
  record.frames = totals.at("frames");
  record.steps = totals.at("steps");
  record.peak_memory = totals.at("peak_memory_bytes");
  record.steps_not_converged = json.at("steps_not_converged");
  if (!json.at("exit_status").is_null()) record.exit_status = json.at("exit_status").get<int>();
  // what earlier versions did not write
  record.instruction_set = json.value("instruction_set", "");
  record.caller = json.value("caller", "");
  record.began = json.value("began", "");
  if (json.contains("ended") && json.at("ended").is_string()) record.ended = json.at("ended");
  record.calls_killed = json.value("calls_killed", 0);
  return record;
}

std::string processor_name() {
  std::ifstream information("/proc/cpuinfo");
  for (std::string line; std::getline(information, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

}  // namespace

std::string run_record_text(const RunRecord& record) {
  return to_json(record).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_run_record(const std::filesystem::path& path, const RunRecord& record) {
  write_file(path, run_record_text(record));
}

std::optional<RunRecord> read_run_record(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  const auto json = nlohmann::json::parse(read_file(path), nullptr, false);
  if (!json.is_object() || json.value("program", nlohmann::json()) != "umax") return std::nullopt;
  try {
    return from_json(json);
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // of another version: the folder is a run's all the same, but its totals are lost
  }
}

std::string how_it_ended(const RunRecord& record, const std::vector<Worker>& at_work) {
  if (!record.ended.empty()) return record.ended;
  if (record.exit_status) return "with exit status " + std::to_string(*record.exit_status);
  const bool is_alive = std::any_of(at_work.begin(), at_work.end(),
                                    [&](const Worker& worker) { return describe(worker) == record.caller; });
  return is_alive ? "not yet: " + record.caller + " is at work"
                  : std::string(without_a_word) + ": killed, or its machine went down" +
                        (record.caller.empty() ? "" : " (" + record.caller + ", begun " + record.began + ")");
}

std::string host_description() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return std::string(name.data()) + " (" + processor_name() + ", " +
         std::to_string(std::thread::hardware_concurrency()) + " cores)";
}

long long peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss * 1024LL;
}

}  // namespace umax
