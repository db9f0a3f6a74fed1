#include "tools/reproduce/report_folder.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* record_name = "report.json";

std::optional<ReportRecord> read_record(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / record_name, error)) return std::nullopt;
  try {
    const nlohmann::json json = nlohmann::json::parse(read_file(folder / record_name));
    if (json.at("program") != "umax reproduce") return std::nullopt;
    return ReportRecord{.sections = json.at("sections"), .pictures = json.at("pictures")};
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

constexpr FolderKind report_kind{"report of umax reproduce", ".umax-report",
                                 [](const fs::path& path) { return read_record(path).has_value(); }};

}  // namespace

ReportFolder::ReportFolder(const fs::path& path, ExistingFolder existing) : folder_(path, existing, report_kind) {
  if (!folder_.is_new()) record_ = read_record(this->path()).value_or(ReportRecord{});
  if (existing == ExistingFolder::overwrite && !folder_.is_new()) {
    std::error_code error;
    for (const auto& [name, digest] : record_.pictures) fs::remove(this->path() / name, error);
    remove_if_empty(tiles());
    remove_runs(runs());
    for (const fs::path& file : {page(), numbers()}) fs::remove(file, error);
    record_ = {};
  }
  for (const fs::path& place : {this->path(), tiles()}) remove_leftovers(place);
  write_record();
}

void ReportFolder::add_section(const std::string& name) {
  if (std::find(record_.sections.begin(), record_.sections.end(), name) != record_.sections.end()) return;
  record_.sections.push_back(name);
  write_record();
}

void ReportFolder::set_picture(const fs::path& png, const std::string& digest) {
  record_.pictures[fs::relative(png, path()).generic_string()] = digest;
  write_record();
}

bool ReportFolder::has_picture(const fs::path& png, const std::string& digest) const {
  std::error_code error;
  const auto known = record_.pictures.find(fs::relative(png, path()).generic_string());
  return known != record_.pictures.end() && known->second == digest && fs::exists(png, error);
}

void ReportFolder::write_record() const {
  nlohmann::ordered_json json;
  json["program"] = "umax reproduce";
  json["sections"] = record_.sections;
  json["pictures"] = record_.pictures;
  write_file(path() / record_name, json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace umax
