// The files of an export: where they are, which may be replaced, and which a later run may remove.
#pragma once

#include <string_view>

#include "tools/exchange/export_list.h"

namespace umax {

/// The folder of an export, made if it is not there. Knows what exports have put into it.
class ExportFolder {
 public:
  /// Clears away what a killed export has left half-written. Throws Error (cannot_create) when the folder cannot be
  /// made.
  ExportFolder(const std::filesystem::path& path, bool overwrite, const ExportLabel& label);

  const std::filesystem::path& path() const { return path_; }

  /// A thing's file; of sequences, its folder.
  std::filesystem::path file_of(const ExportedThing& thing, const FormatTraits& format) const;

  /// Makes a folder in it. Throws Error (cannot_create).
  void make_folder(const std::filesystem::path& folder) const;

  /// Throws Error (cannot_create) where a file is there that may not be replaced.
  void require_new(const std::filesystem::path& file) const;

  /// Writes a file that several exports share; one that is there with other bytes is replaced if files may be. Throws
  /// Error (cannot_create, io_error).
  void write_shared(const std::filesystem::path& file, std::string_view bytes);

  /// Notes that an export makes these files, as its label says, so that `umax run --overwrite` may remove them.
  void claim(const std::vector<std::filesystem::path>& files);

  /// The same of files that have no frames.
  void claim_still(const std::vector<std::filesystem::path>& files);

  /// The same of files that are in no axes and of no frames: materials and textures.
  void claim_plain(const std::vector<std::filesystem::path>& files);

  /// Removes what earlier exports have left that does not fit this one, and says so. Returns "" where there is nothing.
  std::string remove_misfits();

  /// Removes what earlier exports have left in one of its folders, but for these files.
  void keep_only(const std::filesystem::path& inner, const std::vector<std::filesystem::path>& files);

 private:
  void add(const std::vector<std::filesystem::path>& files, const ExportLabel& label);

  std::filesystem::path path_;
  bool overwrite_;
  ExportLabel label_;
};

/// Removes what exports have put into a folder, and the folder when nothing else is in it.
void remove_exports(const std::filesystem::path& folder);

}  // namespace umax
