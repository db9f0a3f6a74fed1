#include "tools/tune/tune_folder.h"

#include "tools/trials/trial_runs.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char *record_name = "tune.json", *program = "umax tune";

bool has_record(const fs::path& folder) {
  return is_record_of(folder / record_name, program);
}

constexpr TrialFolderKind kind{{"tuning of umax", ".umax-tune", has_record}, record_name, program};

}  // namespace

TuneFolder::TuneFolder(const fs::path& path, ExistingFolder existing) : TrialFolder(path, existing, kind) {
  if (is_replaced()) remove_pages();
}

void TuneFolder::remove_pages() const {
  std::error_code error;
  for (const fs::path& file : {page(), sheet(), clip()}) fs::remove(file, error);
}

}  // namespace umax
