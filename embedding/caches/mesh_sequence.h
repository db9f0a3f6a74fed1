// Sequences of meshes: one OBJ or PLY file for each frame, NNNN.obj or NNNN.ply.
#pragma once

#include "embedding/caches/moving_surface.h"

namespace umax {

/// FOLDER/0012.ENDING
std::filesystem::path sequence_file(const std::filesystem::path& folder, int frame, const std::string& ending);

enum class MeshFileKind { obj, ply };

/// One mesh file, whole or not there. Throws Error (cannot_create, io_error).
void write_mesh(const std::filesystem::path& path, MeshFileKind kind, const MovingSurface& surface,
                const SurfaceFrame& frame);

/// Writes each frame as it comes.
class MeshSequenceWriter {
 public:
  /// folder: must be there. surface: must live as long.
  MeshSequenceWriter(const std::filesystem::path& folder, MeshFileKind kind, const MovingSurface& surface)
      : folder_(folder), kind_(kind), surface_(&surface) {}

  void append(const SurfaceFrame& frame) {
    write_mesh(sequence_file(folder_, frame.frame, kind_ == MeshFileKind::obj ? "obj" : "ply"), kind_, *surface_,
               frame);
  }
  void finish() {}

 private:
  std::filesystem::path folder_;
  MeshFileKind kind_;
  const MovingSurface* surface_;
};

}  // namespace umax
