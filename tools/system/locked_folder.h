// A folder that one job holds while it lives, or several that share its work: made or taken over, and never somebody else's.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tools/system/presence.h"

namespace umax {

/// What to do when the folder exists already.
enum class ExistingFolder {
  refuse,     // Error 73
  keep,       // --resume: go on with what is there
  overwrite,  // --overwrite: remove what a job of this kind made, and nothing else
};

/// With whom a folder is held.
enum class FolderUse {
  alone,   // with nobody else: Error 75 as long as anybody is there
  shared,  // with others who share it: Error 75 as long as somebody holds it alone
};

/// What a job of one kind leaves in its folder, by which it is known again.
struct FolderKind {
  const char* name;        // "run of umax", for messages
  const char* place_name;  // ".umax": where those who are at work in the folder are listed, while they are
  bool (*has_record)(const std::filesystem::path&);
  bool has_resume = true;  // whether --resume goes on with it, for messages
};

/// Whether a job of this kind made the folder.
bool is_of_kind(const std::filesystem::path& path, const FolderKind& kind);

/// Throws what LockedFolder would throw for a folder that is there already. Changes nothing: for a look before long
/// work.
void check_folder(const std::filesystem::path& path, ExistingFolder existing, const FolderKind& kind,
                  FolderUse use = FolderUse::alone);

/// Holds a folder while it lives.
class LockedFolder {
 public:
  /// Makes the folder (and its parents) and holds it. Throws Error: cannot_create (73) when it cannot be made, is no
  /// folder, exists and may not be replaced, or holds files that no such job made; try_again (75) when a living one has
  /// it. role: for the others who share it.
  LockedFolder(const std::filesystem::path& path, ExistingFolder existing, const FolderKind& kind,
               FolderUse use = FolderUse::alone, const std::string& role = {});

  const std::filesystem::path& path() const { return path_; }  // absolute
  bool is_new() const { return is_new_; }

  /// Lets others in who share it, from now on.
  void share();
  /// Throws Error: try_again when another one has taken the folder over meanwhile, as may happen to who was suspended;
  /// io_error when it has vanished.
  void require_hold() const;
  Presence& presence() const { return *presence_; }

 private:
  std::filesystem::path path_;
  bool is_new_ = true;
  bool is_shared_ = false;
  std::unique_ptr<Presence> presence_;
};

/// Makes a folder, if it is not there; true if it was not. Throws Error (cannot_create).
bool create_folder(const std::filesystem::path& path);

/// Throws Error (cannot_create).
[[noreturn]] void refuse_folder(const std::filesystem::path& path, const std::string& what, const std::string& remedy);

}  // namespace umax
