#include "tools/exchange/export_files.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <set>
#include <sstream>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "tools/system/locked_folder.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* list_name = ".umax.files";  // relative paths, one a line

std::set<std::string> listed_files(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code error;
  if (!fs::exists(folder / list_name, error)) return names;
  std::istringstream lines(read_file(folder / list_name));
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) names.insert(line);
  return names;
}

/// Whether a process lives that could still write to its half-written file.
bool is_alive(const std::string& process) {
  const long id = std::strtol(process.c_str(), nullptr, 10);
  return id > 0 && (::kill(pid_t(id), 0) == 0 || errno != ESRCH);
}

/// Removes half-written files of processes that are gone.
void remove_leftovers(const fs::path& folder) {
  constexpr std::string_view mark = ".part-";
  std::error_code error;
  std::vector<fs::path> left;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const std::size_t at = name.rfind(mark);
    if (name.starts_with(".") && at != name.npos && !is_alive(name.substr(at + mark.size())))
      left.push_back(entry->path());
  }
  for (const fs::path& path : left) fs::remove(path, error);
}

}  // namespace

ExportFolder::ExportFolder(const fs::path& path, bool overwrite) : path_(path), overwrite_(overwrite) {
  make_folder(path);
}

void ExportFolder::make_folder(const fs::path& folder) const {
  if (!create_folder(folder)) remove_leftovers(folder);
}

fs::path ExportFolder::file_of(const ExportedThing& thing, const FormatTraits& format) const {
  if (format.is_sequence && thing.surface.moves) return path_ / thing.stem;
  return path_ / (thing.stem + "." + (format.is_cache && !thing.surface.moves ? "obj" : format.ending));
}

void ExportFolder::require_new(const fs::path& file) const {
  std::error_code error;
  if (!overwrite_ && fs::exists(file, error))
    throw Error(Fault::cannot_create, {.where = file.string(),
                                       .what = "is there already",
                                       .remedy = "replace it with --overwrite, or choose another folder with -o"});
  if (fs::is_directory(file, error))
    throw Error(Fault::cannot_create,
                {.where = file.string(), .what = "is a folder", .remedy = "choose another folder with -o"});
}

void ExportFolder::write_shared(const fs::path& file, std::string_view bytes) {
  std::error_code error;
  if (fs::is_regular_file(file, error) && read_file(file) == bytes) return;
  require_new(file);
  write_file(file, bytes);
}

void ExportFolder::claim(const std::vector<fs::path>& files) {
  std::set<std::string> names = listed_files(path_);
  const std::size_t before = names.size();
  for (const fs::path& file : files) names.insert(file.lexically_relative(path_).generic_string());
  if (names.size() == before) return;
  std::string text;
  for (const std::string& name : names) text += name + "\n";
  write_file(path_ / list_name, text);
}

void remove_exports(const fs::path& folder) {
  std::error_code error;
  std::set<fs::path> folders;
  for (const std::string& name : listed_files(folder)) {
    const fs::path file = (folder / name).lexically_normal();
    if (name.starts_with("..") || fs::path(name).is_absolute()) continue;  // no list of ours has such a line
    fs::remove(file, error);
    if (file.parent_path() != folder) folders.insert(file.parent_path());
  }
  fs::remove(folder / list_name, error);
  for (const fs::path& inner : folders) {
    remove_leftovers(inner);
    if (fs::is_empty(inner, error)) fs::remove(inner, error);
  }
  remove_leftovers(folder);
  if (fs::is_empty(folder, error)) fs::remove(folder, error);
}

}  // namespace umax
