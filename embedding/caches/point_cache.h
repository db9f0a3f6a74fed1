// Point caches, the positions of all vertices in all frames: PC2 (3ds Max, Blender) and MDD (LightWave, Blender, Houdini).
//
// PC2, little-endian:  char[12] "POINTCACHE2\0", int32 version = 1, #V, float32 start, sampling, int32 #F, and for each
//                      frame #V x 3 float32
// MDD, big-endian:     int32 #F, #V, float32 time[#F], and for each frame #V x 3 float32
//
// start: time of the first frame [s];  sampling: time from one to the next [s];  #V, #F: vertices, frames
#pragma once

#include "core/files/file_writer.h"
#include "embedding/caches/moving_surface.h"

namespace umax {

enum class PointCacheKind { pc2, mdd };

/// Whether the frames are equally far apart, as PC2 has them.
bool is_evenly_spaced(const std::vector<int>& frames);

/// Writes one surface's cache frame by frame; holds one frame at most.
class PointCacheWriter {
 public:
  /// Throws Error (cannot_create); bad_data where there are more vertices than the format counts, or for PC2 frames that
  /// are not equally far apart.
  PointCacheWriter(const std::filesystem::path& path, PointCacheKind kind, Eigen::Index num_vertices,
                   const ClipSpace& clip);

  /// The next of the clip's frames.
  void append(const SurfaceFrame& frame);

  /// Once all frames are there.
  void finish();

 private:
  FileWriter file_;
  PointCacheKind kind_;
  Eigen::Index num_vertices_;
  std::size_t num_frames_, written_ = 0;
  std::vector<char> swapped_;
};

}  // namespace umax
