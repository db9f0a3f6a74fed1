// The list of what exports have put into a folder, with the axes, unit and frames of each file: so that a run that is
// replaced takes them along, and no file that fits no more is left among new ones unsaid.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tools/exchange/exported_things.h"

namespace umax {

/// How a file was made.
struct ExportLabel {
  std::string kin;    // files of the same kin go together and must have the same axes and unit; empty: says them itself
  std::string space;  // "--up z --scale 100"
  std::string frames;  // "1-24" of a cache; empty: it has no frames of its own
};

/// Of what these options make of these frames.
ExportLabel label_of(const ExportOptions& options, const std::vector<int>& frames);

/// By paths relative to the folder, as the folder's list has them; empty where there is none.
using ExportList = std::map<std::string, ExportLabel>;
ExportList read_export_list(const std::filesystem::path& folder);

/// Throws Error (io_error, cannot_create).
void write_export_list(const std::filesystem::path& folder, const ExportList& list);

void remove_export_list(const std::filesystem::path& folder);

/// Files that are there and would not fit what the label says: of its kin, in other axes or another unit.
std::vector<std::string> misfits(const std::filesystem::path& folder, const ExportList& list, const ExportLabel& label);

/// Throws Error (cannot_create) that names the first of them. remedy: what the user can do.
void refuse_misfits(const std::filesystem::path& folder, const ExportOptions& options, const std::string& remedy);

/// Names of the caches in the folder that end before a frame, with their frames: "cow.pc2 (1-24), …"; "": none.
std::string caches_that_end_before(const std::filesystem::path& folder, int frame);

}  // namespace umax
