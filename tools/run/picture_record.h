// pictures.json: with which settings the pictures of a folder are drawn, on which all who draw there agree, and what its
// clip is of.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace umax {

struct PictureRecord {
  std::string settings;          // the scene as resolved, but for the number of frames
  std::string digest;            // of all that decides the pictures: settings, states, files that they name
  int clip_frames = 0;           // of the clip that they are pictures of
  std::vector<int> frames = {};  // that clip.mp4 is of; empty: there is none
  std::vector<int> next = {};    // that a clip has been begun of: clip.mp4 is that one if it is newer than this record
  bool clip_is_shared = false;   // it is of all frames: others draw some of them, or may still ask for it
};

void write_picture_record(const std::filesystem::path& path, const PictureRecord& record);

/// None when there is none, or when the file is damaged.
std::optional<PictureRecord> read_picture_record(const std::filesystem::path& path);

/// The first setting in which two resolved scenes differ: "render.samples is 4 there, 8 here"; empty: in none.
std::string first_difference(const std::string& there, const std::string& here);

}  // namespace umax
