// Alembic (Ogawa): a surface as a PolyMesh below a transform, NAME.abc, and the camera, in a file of its own.
//
// A frame's time is its number over the frame rate, as programs write it that count frames from 0: frame 1 of the clip
// comes to be frame 1 there.
#pragma once

#include "embedding/caches/alembic_archive.h"
#include "embedding/caches/moving_surface.h"

namespace umax {

/// Writes a surface frame by frame; one that does not move has one frame.
class AlembicWriter {
 public:
  /// surface and clip must live as long. Throws Error (cannot_create).
  AlembicWriter(const std::filesystem::path& path, const MovingSurface& surface, const ClipSpace& clip);
  void append(const SurfaceFrame& frame);
  void finish();

 private:
  void write_first();
  std::vector<AlembicObject> face_sets();

  const MovingSurface* surface_;
  const ClipSpace* clip_;
  AlembicArchive archive_;
  AlembicTimes times_;
  AlembicProperty bounds_, positions_, indices_, counts_, velocities_, normals_, texture_, colors_;
};

/// Throws Error (cannot_create, io_error).
void write_alembic_camera(const std::filesystem::path& path, const ClipCamera& camera, const ClipSpace& clip);

}  // namespace umax
