// A folder that one job holds while it lives: made or taken over, locked, and never somebody else's.
#pragma once

#include <filesystem>
#include <string>

namespace umax {

/// What to do when the folder exists already.
enum class ExistingFolder {
  refuse,     // Error 73
  keep,       // --resume: go on with what is there
  overwrite,  // --overwrite: remove what a job of this kind made, and nothing else
};

/// What a job of one kind leaves in its folder, by which it is known again.
struct FolderKind {
  const char* name;       // "run of umax", for messages
  const char* lock_name;  // ".umax.lock"
  bool (*has_record)(const std::filesystem::path&);
  bool has_resume = true;  // whether --resume goes on with it, for messages
};

/// Whether a job of this kind made the folder.
bool is_of_kind(const std::filesystem::path& path, const FolderKind& kind);

/// Throws what LockedFolder would throw for a folder that is there already. Changes nothing: for a look before long
/// work.
void check_folder(const std::filesystem::path& path, ExistingFolder existing, const FolderKind& kind);

/// Owns the lock on a folder while it lives.
class LockedFolder {
 public:
  /// Makes the folder (and its parents) and locks it. Throws Error: cannot_create (73) when it cannot be made, is no
  /// folder, exists and may not be replaced, or holds files that no such job made; try_again (75) when a living one has
  /// it.
  LockedFolder(const std::filesystem::path& path, ExistingFolder existing, const FolderKind& kind);
  ~LockedFolder();
  LockedFolder(const LockedFolder&) = delete;
  LockedFolder& operator=(const LockedFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }  // absolute
  bool is_new() const { return is_new_; }

 private:
  std::filesystem::path path_;
  bool is_new_ = true;
  int lock_ = -1;
};

/// Makes a folder, if it is not there; true if it was not. Throws Error (cannot_create).
bool create_folder(const std::filesystem::path& path);

/// Throws Error (cannot_create).
[[noreturn]] void refuse_folder(const std::filesystem::path& path, const std::string& what, const std::string& remedy);

}  // namespace umax
