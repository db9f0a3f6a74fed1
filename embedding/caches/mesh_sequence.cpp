#include "embedding/caches/mesh_sequence.h"

#include <fmt/format.h>

#include "core/files/write_file.h"
#include "embedding/caches/obj_file.h"
#include "embedding/caches/ply_file.h"

namespace umax {

void write_mesh(const std::filesystem::path& path, MeshFileKind kind, const MovingSurface& surface,
                const SurfaceFrame& frame) {
  write_file(path, kind == MeshFileKind::obj ? obj_text(surface, frame.positions) : ply_bytes(surface, frame));
}

std::filesystem::path sequence_file(const std::filesystem::path& folder, int frame, const std::string& ending) {
  return folder / fmt::format("{:04}.{}", frame, ending);
}

}  // namespace umax
