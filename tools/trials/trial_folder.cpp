#include "tools/trials/trial_folder.h"

#include <fmt/format.h>

#include "core/files/write_file.h"
#include "tools/run/run_folder.h"
#include "tools/trials/trial_runs.h"

namespace umax {
namespace fs = std::filesystem;

TrialFolder::TrialFolder(const fs::path& path, ExistingFolder existing, const TrialFolderKind& kind)
    : folder_(path, existing, kind.folder),
      record_(kind.record),
      is_replaced_(existing == ExistingFolder::overwrite && !folder_.is_new()) {
  const fs::path scenes = this->path() / "scenes", runs = this->path() / "runs";
  if (is_replaced_) remove_trials(scenes, runs);
  remove_leftovers(this->path());
  create_folder(scenes);
  create_folder(runs);
  std::error_code error;
  if (!fs::exists(record(), error)) write_file(record(), fmt::format("{{ \"program\": \"{}\" }}\n", kind.program));
}

}  // namespace umax
