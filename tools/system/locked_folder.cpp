#include "tools/system/locked_folder.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/files/disk_error.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* owner_claim = "owner";

[[noreturn]] void refuse_for(const fs::path& path, const Worker& worker) {
  throw Error(Fault::try_again, {path.string(), "is in use by another umax that is still running, " + describe(worker),
                                 "", "wait until it ends, or choose another folder with -o"});
}

/// Throws while somebody is there with whom the folder cannot be held.
void check_free(const fs::path& path, const FolderKind& kind, FolderUse use) {
  const fs::path place = path / kind.place_name;
  if (const auto owner = holder_of(place, owner_claim)) refuse_for(path, *owner);
  if (use == FolderUse::shared) return;
  if (const std::vector<Worker> workers = workers_in(place); !workers.empty()) refuse_for(path, workers.front());
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
  refuse_folder(path, std::string("cannot be created (") + std::strerror(reason) + ")", disk_remedy(reason));
}

bool is_of_kind(const fs::path& path, const FolderKind& kind) {
  std::error_code error;
  return fs::is_directory(path / kind.place_name, error) || kind.has_record(path);
}

void check_folder(const fs::path& path, ExistingFolder existing, const FolderKind& kind, FolderUse use) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    if (fs::exists(path, error)) refuse_folder(path, "is a file, not a folder", "choose another folder with -o");
    return;
  }
  check_free(path, kind, use);
  if (existing == ExistingFolder::refuse)
    refuse_folder(path, "exists already",
                  std::string(kind.has_resume ? "go on with it by --resume, " : "") +
                      "replace it by --overwrite, or choose another folder with -o");
  if (!fs::is_empty(path, error) && !is_of_kind(path, kind))
    refuse_folder(path, std::string("holds files but no ") + kind.name + ", and is left alone",
                  "choose another folder with -o");
}

LockedFolder::LockedFolder(const fs::path& path, ExistingFolder existing, const FolderKind& kind, FolderUse use,
                           const std::string& role)
    : path_(absolute_folder(path)), is_shared_(use == FolderUse::shared) {
  is_new_ = create_folder(path_);
  if (!is_new_) check_folder(path_, existing, kind, use);
  const fs::path place = path_ / kind.place_name;
  presence_ = std::make_unique<Presence>(place, role);
  // everybody is there first and looks then: of two who come at once, one gives way
  if (is_shared_) {
    if (const auto owner = holder_of(place, owner_claim)) refuse_for(path_, *owner);
    return;
  }
  if (!presence_->claim(owner_claim)) refuse_for(path_, holder_of(place, owner_claim).value_or(Worker{}));
  if (const std::vector<Worker> others = presence_->others(); !others.empty()) refuse_for(path_, others.front());
  presence_->sweep();
}

void LockedFolder::share() {
  presence_->release(owner_claim);
  is_shared_ = true;
}

void LockedFolder::require_hold() const {
  if (is_shared_ || presence_->holds(owner_claim)) return;
  std::error_code error;
  if (!fs::exists(path_, error)) throw vanished(path_);
  throw Error(Fault::try_again,
              {path_.string(), "has been taken over by another umax, as this one had given no sign for long", "",
               "leave it to that one, or go on with --resume when it has ended"});
}

}  // namespace umax
