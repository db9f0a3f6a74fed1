#include "tools/fit/fit_folder.h"

#include "core/files/read_file.h"
#include "tools/fit/fit_report.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* snippet_name = "material.toml";

bool has_snippet(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / snippet_name, error) &&
         read_file(folder / snippet_name).starts_with(snippet_beginning);
}

constexpr FolderKind fit_kind{"fit of umax", ".umax-fit", has_snippet, false};

}  // namespace

void check_fit_folder(const fs::path& path, ExistingFolder existing) {
  check_folder(path, existing, fit_kind);
}

FitFolder::FitFolder(const fs::path& path, ExistingFolder existing) : folder_(path, existing, fit_kind) {}

fs::path FitFolder::snippet() const {
  return path() / snippet_name;
}

}  // namespace umax
