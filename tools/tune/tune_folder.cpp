#include "tools/tune/tune_folder.h"

#include <nlohmann/json.hpp>

#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* record_name = "tune.json";

bool has_record(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(folder / record_name, error)) return false;
  const auto json = nlohmann::json::parse(read_file(folder / record_name), nullptr, false);
  return json.is_object() && json.value("program", nlohmann::json()) == "umax tune";
}

constexpr FolderKind tune_kind{"tuning of umax", ".umax-tune.lock", has_record};

/// The scenes that variants were made of; runs have a copy.
void remove_scenes(const fs::path& scenes, const fs::path& runs) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(scenes, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().extension() == ".toml" && is_run_folder(runs / entry->path().stem()))
      files.push_back(entry->path());
  for (const fs::path& file : files) fs::remove(file, error);
  remove_if_empty(scenes);
}

}  // namespace

TuneFolder::TuneFolder(const fs::path& path, ExistingFolder existing) : folder_(path, existing, tune_kind) {
  if (existing == ExistingFolder::overwrite && !folder_.is_new()) {
    remove_scenes(this->path() / "scenes", this->path() / "runs");
    remove_runs(this->path() / "runs");
    remove_pages();
  }
  remove_leftovers(this->path());
  create_folder(this->path() / "scenes");
  create_folder(this->path() / "runs");
  std::error_code error;
  if (!fs::exists(record(), error)) write_file(record(), "{ \"program\": \"umax tune\" }\n");
}

fs::path TuneFolder::record() const {
  return path() / record_name;
}

void TuneFolder::remove_pages() const {
  std::error_code error;
  for (const fs::path& file : {page(), sheet(), clip()}) fs::remove(file, error);
}

}  // namespace umax
