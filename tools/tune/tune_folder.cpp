#include "tools/tune/tune_folder.h"

#include "core/files/write_file.h"
#include "tools/run/run_folder.h"
#include "tools/trials/trial_runs.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* record_name = "tune.json";

bool has_record(const fs::path& folder) {
  return is_record_of(folder / record_name, "umax tune");
}

constexpr FolderKind tune_kind{"tuning of umax", ".umax-tune", has_record};

}  // namespace

TuneFolder::TuneFolder(const fs::path& path, ExistingFolder existing) : folder_(path, existing, tune_kind) {
  if (existing == ExistingFolder::overwrite && !folder_.is_new()) {
    remove_trials(this->path() / "scenes", this->path() / "runs");
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
