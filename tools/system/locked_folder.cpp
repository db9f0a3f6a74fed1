#include "tools/system/locked_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "core/base/error.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

int open_lock(const fs::path& path, const FolderKind& kind) {
  const fs::path file = path / kind.lock_name;
  const int lock = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock < 0)
    refuse_folder(path, std::string("cannot be written to (") + std::strerror(errno) + ")",
                  "choose a folder that can be written with -o");
  if (::flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  const int reason = errno;
  ::close(lock);
  if (reason == EWOULDBLOCK)
    throw Error(Fault::try_again, {path.string(), "is in use by another umax that is still running", "",
                                   "wait until it ends, or choose another folder with -o"});
  refuse_folder(path, std::string("cannot be locked (") + std::strerror(reason) + ")",
                "choose a folder on another file system with -o");
}

/// Whether a living job holds the folder. Creates nothing.
bool is_locked(const fs::path& path, const FolderKind& kind) {
  const int lock = ::open((path / kind.lock_name).c_str(), O_RDWR | O_CLOEXEC);
  if (lock < 0) return false;
  const bool locked = ::flock(lock, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(lock);
  return locked;
}

fs::path absolute_folder(const fs::path& path) {
  const fs::path full = fs::absolute(path).lexically_normal();
  return full.has_filename() ? full : full.parent_path();
}

}  // namespace

void refuse_folder(const fs::path& path, const std::string& what, const std::string& remedy) {
  throw Error(Fault::cannot_create, {path.string(), what, "", remedy});
}

bool create_folder(const fs::path& path) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (::mkdir(path.c_str(), 0777) == 0) return true;
  const int reason = errno;
  if (fs::exists(path, error)) return false;
  refuse_folder(path, std::string("cannot be created (") + std::strerror(reason) + ")",
                "choose a folder that can be written with -o");
}

bool is_of_kind(const fs::path& path, const FolderKind& kind) {
  std::error_code error;
  return fs::exists(path / kind.lock_name, error) || kind.has_record(path);
}

void check_folder(const fs::path& path, ExistingFolder existing, const FolderKind& kind) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    if (fs::exists(path, error)) refuse_folder(path, "is a file, not a folder", "choose another folder with -o");
    return;
  }
  if (is_locked(path, kind)) ::close(open_lock(path, kind));  // says who has it
  if (existing == ExistingFolder::refuse)
    refuse_folder(path, "exists already",
                  std::string(kind.has_resume ? "go on with it by --resume, " : "") +
                      "replace it by --overwrite, or choose another folder with -o");
  if (!fs::is_empty(path, error) && !is_of_kind(path, kind))
    refuse_folder(path, std::string("holds files but no ") + kind.name + ", and is left alone",
                  "choose another folder with -o");
}

LockedFolder::LockedFolder(const fs::path& path, ExistingFolder existing, const FolderKind& kind)
    : path_(absolute_folder(path)) {
  is_new_ = create_folder(path_);
  if (!is_new_) check_folder(path_, existing, kind);
  lock_ = open_lock(path_, kind);
}

LockedFolder::~LockedFolder() {
  ::close(lock_);
}

}  // namespace umax
