#include "tools/farm/farm_record.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"

namespace umax {
namespace {

using Json = nlohmann::ordered_json;

Json jobs_json(const std::vector<SubmittedJob>& jobs) {
  Json list = Json::array();
  for (const SubmittedJob& job : jobs) list.push_back({{"name", job.name}, {"id", job.id}, {"tasks", job.tasks}});
  return list;
}

}  // namespace

void write_farm_record(const std::filesystem::path& file, const FarmRecord& record) {
  const Json json{{"program", "umax farm"},
                  {"version", record.version},
                  {"command", record.command},
                  {"name", record.name},
                  {"varied", record.is_varied},
                  {"frames", record.num_frames},
                  {"frames_per_job", record.frames_per_job},
                  {"runs", record.runs},
                  {"jobs", jobs_json(record.jobs)}};
  write_file(file, json.dump(2) + "\n");
}

FarmRecord read_farm_record(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw Error(Fault::not_found,
                {.where = file.string(), .what = "is not there", .remedy = "name the folder of a umax farm"});
  try {
    const Json json = Json::parse(read_file(file));
    FarmRecord record{.version = json.at("version"),
                      .command = json.at("command"),
                      .name = json.at("name"),
                      .is_varied = json.at("varied"),
                      .num_frames = json.at("frames"),
                      .frames_per_job = json.at("frames_per_job"),
                      .runs = json.at("runs"),
                      .jobs = {}};
    for (const Json& job : json.at("jobs")) record.jobs.push_back({job.at("name"), job.at("id"), job.at("tasks")});
    return record;
  } catch (const Json::exception& problem) {
    throw Error(Fault::bad_data, {.where = file.string(),
                                  .what = std::string("is no record of umax farm: ") + problem.what(),
                                  .remedy = "name the folder of a umax farm"});
  }
}

std::vector<QueuedTask> unfinished_tasks(const FarmRecord& record, const QueueFunctions& queue) {
  std::vector<QueuedTask> tasks = unfinished_tasks(queue);
  std::erase_if(tasks, [&](const QueuedTask& task) {
    return std::none_of(record.jobs.begin(), record.jobs.end(),
                        [&](const SubmittedJob& job) { return job.id == task.job; });
  });
  return tasks;
}

}  // namespace umax
