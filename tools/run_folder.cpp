#include "tools/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "core/error.h"
#include "tools/frame_list.h"
#include "tools/run_record.h"
#include "tools/step_plots.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* lock_name = ".umax.lock";

[[noreturn]] void refuse(const fs::path& path, const std::string& what, const std::string& remedy) {
  throw Error(ExitCode::cannot_create, {path.string(), what, "", remedy});
}

/// Makes the folder; true if it was not there before.
bool make_folder(const fs::path& path) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (::mkdir(path.c_str(), 0777) == 0) return true;
  const int reason = errno;
  if (fs::exists(path, error)) return false;
  refuse(path, std::string("cannot be created (") + std::strerror(reason) + ")",
         "choose a folder that can be written with -o");
}

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
      refuse(file, "cannot be removed (" + error.message() + ")", "choose another folder with -o");
}

void remove_numbered(const fs::path& folder, const std::vector<std::string>& extensions) {
  remove_files(folder, [&](const fs::path& file) {
    const bool known = std::find(extensions.begin(), extensions.end(), file.extension().string()) != extensions.end();
    return (known && is_numbered(file.stem().string())) || is_leftover(file);
  });
  std::error_code error;
  if (fs::is_empty(folder, error)) fs::remove(folder, error);
}

void remove_run(const RunFolder& folder) {
  // the record goes last: until then the folder is known as a run's, should we be killed in between
  folder.remove_pictures();
  remove_numbered(folder.states(), {".state"});
  std::error_code error;
  for (const char* name : step_plot_names) fs::remove(folder.plots() / name, error);
  if (fs::is_empty(folder.plots(), error)) fs::remove(folder.plots(), error);
  for (const fs::path& file : {folder.steps(), folder.scene(), folder.record()}) fs::remove(file, error);
}

int open_lock(const fs::path& path) {
  const fs::path file = path / lock_name;
  const int lock = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock < 0)
    refuse(path, std::string("cannot be written to (") + std::strerror(errno) + ")",
           "choose a folder that can be written with -o");
  if (::flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  const int reason = errno;
  ::close(lock);
  if (reason == EWOULDBLOCK)
    throw Error(ExitCode::try_again, {path.string(), "is in use by another umax that is still running", "",
                                      "wait until it ends, or choose another folder with -o"});
  refuse(path, std::string("cannot be locked (") + std::strerror(reason) + ")",
         "choose a folder on another file system with -o");
}

/// Whether a living run holds the folder. Creates nothing.
bool is_locked(const fs::path& path) {
  const int lock = ::open((path / lock_name).c_str(), O_RDWR | O_CLOEXEC);
  if (lock < 0) return false;
  const bool locked = ::flock(lock, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(lock);
  return locked;
}

}  // namespace

void check_run_folder(const fs::path& path, ExistingFolder existing) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    if (fs::exists(path, error)) refuse(path, "is a file, not a folder", "choose another folder with -o");
    return;
  }
  if (is_locked(path)) ::close(open_lock(path));  // says who has it
  if (existing == ExistingFolder::refuse)
    refuse(path, "exists already",
           "go on with it by --resume, replace it by --overwrite, or choose another folder with -o");
  if (!fs::is_empty(path, error) && !is_run_folder(path))
    refuse(path, "holds files but no run of umax, and is left alone", "choose another folder with -o");
}

RunFolder::RunFolder(const fs::path& path, ExistingFolder existing) : path_(fs::absolute(path).lexically_normal()) {
  if (!path_.has_filename()) path_ = path_.parent_path();
  const bool is_new = make_folder(path_);
  if (!is_new) check_run_folder(path_, existing);
  lock_ = open_lock(path_);
  if (is_new) return;
  if (existing == ExistingFolder::overwrite) remove_run(*this);
  for (const fs::path& folder : {path_, states(), frames(), plots()}) remove_files(folder, is_leftover);
}

RunFolder::~RunFolder() {
  ::close(lock_);
}

fs::path RunFolder::state(int frame) const {
  return state_path(path_, frame);
}

fs::path RunFolder::picture(int frame, const std::string& extension) const {
  return frames() / (frame_name(frame) + extension);
}

void RunFolder::remove_pictures() const {
  remove_numbered(frames(), {".png", ".exr"});
  std::error_code error;
  fs::remove(clip(), error);
}

void create_folder(const fs::path& path) {
  make_folder(path);
}

bool is_run_folder(const fs::path& path) {
  std::error_code error;
  return fs::exists(path / lock_name, error) || read_run_record(path / "run.json").has_value();
}

fs::path state_path(const fs::path& run_folder, int frame) {
  return run_folder / "states" / (frame_name(frame) + ".state");
}

int count_states(const fs::path& run_folder) {
  int count = 0;
  std::error_code error;
  while (fs::exists(state_path(run_folder, count + 1), error)) ++count;
  return count;
}

}  // namespace umax
