#include "tools/run/run_folder.h"

#include <algorithm>
#include <system_error>

#include "core/base/error.h"
#include "tools/exchange/export_files.h"
#include "tools/run/frame_list.h"
#include "tools/run/run_record.h"
#include "tools/run/step_plots.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr FolderKind run_kind{"run of umax", ".umax",
                              [](const fs::path& path) { return read_run_record(path / "run.json").has_value(); }};

bool is_numbered(const std::string& stem) {
  return stem.size() >= 4 && std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_leftover(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with(".") && name.find(".part-") != std::string::npos;
}

/// Removes the files of `folder` that `ours` accepts, then the folder if nothing is left in it.
template <class Predicate>
void remove_files(const fs::path& folder, Predicate ours) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->is_regular_file(error) && ours(entry->path())) files.push_back(entry->path());
  for (const fs::path& file : files)
    if (!fs::remove(file, error))
      refuse_folder(file, "cannot be removed (" + error.message() + ")", "choose another folder with -o");
}

void remove_numbered(const fs::path& folder, const std::vector<std::string>& extensions) {
  remove_files(folder, [&](const fs::path& file) {
    const bool known = std::find(extensions.begin(), extensions.end(), file.extension().string()) != extensions.end();
    return (known && is_numbered(file.stem().string())) || is_leftover(file);
  });
  remove_if_empty(folder);
}

/// How many of the files of frames 1, 2, … are there before one is missing.
template <class PathOf>
int count_up_to_gap(const PathOf& path_of) {
  int count = 0;
  std::error_code error;
  while (fs::exists(path_of(count + 1), error)) ++count;
  return count;
}

void empty_run(const RunFolder& folder) {
  // the record goes last: until then the folder is known as a run's, should we be killed in between
  folder.remove_pictures();
  remove_numbered(folder.states(), {".state"});
  remove_exports(folder.exports());
  std::error_code error;
  for (const char* name : step_plot_names) fs::remove(folder.plots() / name, error);
  remove_if_empty(folder.plots());
  for (const fs::path& file :
       {motion_path(folder.path()), folder.steps(), folder.log(), folder.scene(), folder.record()})
    fs::remove(file, error);
}

}  // namespace

void check_run_folder(const fs::path& path, ExistingFolder existing, FolderUse use) {
  check_folder(path, existing, run_kind, use);
}

std::vector<Worker> workers_in_run(const fs::path& path) {
  return workers_in(path / run_kind.place_name);
}

bool is_abandoned(const fs::path& path) {
  std::error_code error;
  return fs::exists(path / run_kind.place_name, error) && workers_in_run(path).empty();
}

RunFolder::RunFolder(const fs::path& path, ExistingFolder existing, FolderUse use, const std::string& role)
    : folder_(path, existing, run_kind, use, role) {
  if (folder_.is_new() || use == FolderUse::shared) return;
  if (existing == ExistingFolder::overwrite) empty_run(*this);
  remove_leftovers();
}

void RunFolder::remove_leftovers() const {
  for (const fs::path& folder : {path(), states(), frames(), plots()}) umax::remove_leftovers(folder);
}

fs::path RunFolder::state(int frame) const {
  return state_path(path(), frame);
}

fs::path RunFolder::picture(int frame, const std::string& extension) const {
  return frames() / (frame_name(frame) + extension);
}

void RunFolder::remove_picture(int frame) const {
  std::error_code error;
  for (const char* extension : {".png", ".exr"}) fs::remove(picture(frame, extension), error);
}

void RunFolder::remove_pictures() const {
  remove_numbered(frames(), {".png", ".exr"});
  std::error_code error;
  fs::remove(clip(), error);
  fs::remove(pictures(), error);
}

Error explained(const RunFolder& folder, const Error& error) {
  std::error_code unknown;
  const bool is_gone = error.fault() == Fault::not_found && !fs::exists(folder.path(), unknown);
  return is_gone ? vanished(folder.path()) : error;
}

void remove_run(const fs::path& path) {
  {
    const RunFolder emptied(path, ExistingFolder::overwrite);
  }
  remove_if_empty(path);
}

void remove_runs(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> runs;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->is_directory(error) && is_run_folder(entry->path())) runs.push_back(entry->path());
  for (const fs::path& run : runs) remove_run(run);
  remove_if_empty(folder);
}

void remove_leftovers(const fs::path& folder) {
  remove_files(folder, is_leftover);
}

void remove_if_empty(const fs::path& folder) {
  std::error_code error;
  if (fs::is_empty(folder, error)) fs::remove(folder, error);
}

bool is_run_folder(const fs::path& path) {
  return is_of_kind(path, run_kind);
}

fs::path motion_path(const fs::path& run_folder) {
  return run_folder / "motion.json";
}

fs::path state_path(const fs::path& run_folder, int frame) {
  return run_folder / "states" / (frame_name(frame) + ".state");
}

fs::path picture_path(const fs::path& run_folder, int frame) {
  return run_folder / "frames" / (frame_name(frame) + ".png");
}

int count_states(const fs::path& run_folder) {
  return count_up_to_gap([&](int frame) { return state_path(run_folder, frame); });
}

void require_states(const fs::path& run_folder, const std::vector<int>& frames) {
  for (const int frame : frames)
    if (std::error_code error; !fs::exists(state_path(run_folder, frame), error))
      throw Error(Fault::not_found, {.where = state_path(run_folder, frame).string(),
                                     .what = "there is no state of this frame",
                                     .remedy = "simulate it first, or name other frames with --frames"});
}

int count_pictures(const fs::path& run_folder) {
  return count_up_to_gap([&](int frame) { return picture_path(run_folder, frame); });
}

}  // namespace umax
