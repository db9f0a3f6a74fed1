// The folder of a report: what is in it, what was made for it, who may write to it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tools/system/locked_folder.h"

namespace umax {

/// report.json: what the folder's files were made from, so that nothing is made twice.
struct ReportRecord {
  std::vector<std::string> sections;            // that the page has
  std::map<std::string, std::string> pictures;  // file name: digest of all that decides the picture
};

/// Owns the lock on a report's folder while it lives.
class ReportFolder {
 public:
  /// Throws what LockedFolder throws. overwrite: removes the old report and its runs.
  ReportFolder(const std::filesystem::path& path, ExistingFolder existing);

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path page() const { return path() / "index.html"; }
  std::filesystem::path numbers() const { return path() / "report.csv"; }
  std::filesystem::path runs() const { return path() / "runs"; }
  std::filesystem::path tiles() const { return path() / "tiles"; }

  const ReportRecord& record() const { return record_; }
  /// Keeps the change on disk. Throws Error (cannot_create, io_error).
  void add_section(const std::string& name);
  void set_picture(const std::filesystem::path& png, const std::string& digest);
  /// Whether the picture is there and was made from the same.
  bool has_picture(const std::filesystem::path& png, const std::string& digest) const;

 private:
  void write_record() const;
  LockedFolder folder_;
  ReportRecord record_;
};

}  // namespace umax
