#include "tools/aim/aim_folder.h"

#include <vector>

#include "tools/trials/trial_runs.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char *record_name = "aim.json", *program = "umax aim";

bool has_record(const fs::path& folder) {
  return is_record_of(folder / record_name, program);
}

constexpr TrialFolderKind kind{{"search of umax aim", ".umax-aim", has_record}, record_name, program};

}  // namespace

AimFolder::AimFolder(const fs::path& path, ExistingFolder existing) : TrialFolder(path, existing, kind) {
  if (is_replaced()) remove_pages();
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
