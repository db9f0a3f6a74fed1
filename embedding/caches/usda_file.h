// USD as text (.usda): a surface with its samples in time, and the stage that puts surfaces and camera together.
//
// NAME.usda    Xform NAME with Mesh "surface" and its Material. Time codes are frame numbers. Above a size the samples
//              go to NAME.clips/0001.usda, …, as value clips: each holds the first frame of the next one, too, so that
//              what lies between frames is interpolated across their borders.
// scene.usda   references all of them, and has the camera.
#pragma once

#include <optional>

#include "core/files/file_writer.h"
#include "embedding/caches/moving_surface.h"

namespace umax {

/// A name as USD allows it for prims: letters, digits and _.
std::string usd_name(const std::string& name);

/// The whole file of a surface that does not move.
std::string still_usda(const MovingSurface& surface, const SurfaceFrame& shape, const ClipSpace& clip);

/// Samples of one layer, each attribute gathered in a file of its own until the layer is written.
class UsdaSamples {
 public:
  /// The files are made beside `layer` and vanish with this.
  explicit UsdaSamples(const std::filesystem::path& layer);
  void append(const SurfaceFrame& frame);
  void append_to(FileWriter& file);
  long long size() const;

 private:
  FileWriter points_, velocities_, normals_, extent_;
};

/// Writes a surface that moves, frame by frame.
class UsdaWriter {
 public:
  /// largest: [bytes] of a file from which on its samples become value clips. surface and clip must live as long. Throws
  /// Error (cannot_create).
  UsdaWriter(const std::filesystem::path& path, const MovingSurface& surface, const ClipSpace& clip,
             long long largest = 200'000'000);
  void append(const SurfaceFrame& frame);
  /// Throws Error (cannot_create, io_error).
  void finish();

  /// What it has written, the clips included.
  const std::vector<std::filesystem::path>& files() const { return files_; }
  std::filesystem::path folder_of_clips() const;

 private:
  void finish_clip();
  void write_manifest(const std::string& root);
  std::string clips_text(const std::string& root) const;

  std::filesystem::path path_;
  const MovingSurface* surface_;
  const ClipSpace* clip_;
  long long largest_;
  FileWriter file_;  // made at once: what cannot be made is found out before the first frame
  std::optional<UsdaSamples> samples_;
  bool is_full_ = false;
  long long still_size_ = 0;      // [bytes] of what is no sample
  std::vector<int> clip_starts_;  // first frames; one alone: no clips
  std::vector<std::filesystem::path> files_;
};

/// What a stage refers to.
struct StagePart {
  std::string name;  // as usd_name() gives it
  std::string file;  // beside the stage
};
std::string stage_usda(const std::vector<StagePart>& parts, const ClipCamera& camera, const ClipSpace& clip);

}  // namespace umax
