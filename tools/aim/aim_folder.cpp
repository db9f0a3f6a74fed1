#include "tools/aim/aim_folder.h"

#include <vector>

#include "core/files/write_file.h"
#include "tools/run/run_folder.h"
#include "tools/trials/trial_runs.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* record_name = "aim.json";

bool has_record(const fs::path& folder) {
  return is_record_of(folder / record_name, "umax aim");
}

constexpr FolderKind aim_kind{"search of umax aim", ".umax-aim.lock", has_record};

}  // namespace

AimFolder::AimFolder(const fs::path& path, ExistingFolder existing) : folder_(path, existing, aim_kind) {
  if (existing == ExistingFolder::overwrite && !folder_.is_new()) {
    remove_trials(this->path() / "scenes", this->path() / "runs");
    remove_pages();
  }
  remove_leftovers(this->path());
  create_folder(this->path() / "scenes");
  create_folder(this->path() / "runs");
  std::error_code error;
  if (!fs::exists(record(), error)) write_file(record(), "{ \"program\": \"umax aim\" }\n");
}

fs::path AimFolder::record() const {
  return path() / record_name;
}

void AimFolder::remove_pages() const {
  std::error_code error;
  std::vector<fs::path> files{page(), strip(), lines()};
  for (fs::directory_iterator entry(path(), error), end; !error && entry != end; entry.increment(error))
    if (entry->path().extension() == ".svg" && entry->path().filename().string().starts_with("plot-"))
      files.push_back(entry->path());
  for (const fs::path& file : files) fs::remove(file, error);
}

}  // namespace umax
