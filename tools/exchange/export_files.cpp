#include "tools/exchange/export_files.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <set>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "tools/system/locked_folder.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

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

ExportFolder::ExportFolder(const fs::path& path, bool overwrite, const ExportLabel& label)
    : path_(path), overwrite_(overwrite), label_(label) {
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

void ExportFolder::add(const std::vector<fs::path>& files, const ExportLabel& label) {
  ExportList list = read_export_list(path_);
  for (const fs::path& file : files) list[file.lexically_relative(path_).generic_string()] = label;
  write_export_list(path_, list);
}

void ExportFolder::claim(const std::vector<fs::path>& files) {
  add(files, label_);
}

void ExportFolder::claim_still(const std::vector<fs::path>& files) {
  add(files, {.kin = label_.kin, .space = label_.space, .frames = ""});
}

void ExportFolder::claim_plain(const std::vector<fs::path>& files) {
  add(files, {});
}

std::string ExportFolder::remove_misfits() {
  ExportList list = read_export_list(path_);
  const std::vector<std::string> found = misfits(path_, list, label_);
  if (found.empty()) return {};
  const std::string space = list.at(found.front()).space;
  std::error_code error;
  for (const std::string& name : found) {
    fs::remove(path_ / name, error);
    list.erase(name);
  }
  write_export_list(path_, list);
  return "removed what was exported with " + space + ": " + found.front() +
         (found.size() > 1 ? " and " + std::to_string(found.size() - 1) + " more" : std::string());
}

void ExportFolder::keep_only(const fs::path& inner, const std::vector<fs::path>& files) {
  ExportList list = read_export_list(path_);
  const std::string prefix = inner.lexically_relative(path_).generic_string() + "/";
  const std::size_t before = list.size();
  std::error_code error;
  std::erase_if(list, [&](const auto& entry) {
    const bool is_old =
        entry.first.starts_with(prefix) && std::find(files.begin(), files.end(), path_ / entry.first) == files.end();
    if (is_old) fs::remove(path_ / entry.first, error);
    return is_old;
  });
  if (list.size() == before) return;
  write_export_list(path_, list);
  if (fs::is_empty(inner, error)) fs::remove(inner, error);
}

void remove_exports(const fs::path& folder) {
  std::error_code error;
  std::set<fs::path> folders;
  for (const auto& [name, label] : read_export_list(folder)) {
    const fs::path file = (folder / name).lexically_normal();
    if (name.starts_with("..") || fs::path(name).is_absolute()) continue;  // no list of ours has such a line
    fs::remove(file, error);
    if (file.parent_path() != folder) folders.insert(file.parent_path());
  }
  remove_export_list(folder);
  for (const fs::path& inner : folders) {
    remove_leftovers(inner);
    if (fs::is_empty(inner, error)) fs::remove(inner, error);
  }
  remove_leftovers(folder);
  if (fs::is_empty(folder, error)) fs::remove(folder, error);
}

}  // namespace umax
