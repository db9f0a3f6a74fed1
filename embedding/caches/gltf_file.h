// glTF 2.0: a surface as a mesh with a morph target for each frame, NAME.gltf with its numbers in NAME.bin.
//
// The mesh is the first frame; target i is what frame i + 2 differs from it by. The weights' animation turns one target
// after the other on, linearly, so that positions between frames are those between their neighbours.
#pragma once

#include <optional>

#include "core/files/file_writer.h"
#include "embedding/caches/corner_values.h"
#include "embedding/caches/moving_surface.h"

namespace umax {

/// Writes a surface frame by frame; one that does not move has one frame. The first #V vertices are the surface's, in
/// their order; copies follow where a vertex has several texture coordinates.
class GltfWriter {
 public:
  /// surface and clip must live as long. Throws Error (cannot_create).
  GltfWriter(const std::filesystem::path& path, const MovingSurface& surface, const ClipSpace& clip,
             const std::optional<ClipCamera>& camera);
  void append(const SurfaceFrame& frame);
  /// Throws Error (cannot_create, io_error).
  void finish();

  /// NAME.gltf and NAME.bin
  std::vector<std::filesystem::path> files() const { return {json_.path(), numbers_.path()}; }

 private:
  int add_accessor(std::string_view bytes, Eigen::Index count, const char* type, int component, int target,
                   const std::string& more = {});
  int add_points(const FloatPoints& values, bool with_range);
  void write_first(const SurfaceFrame& frame);
  void write_indices();
  std::string animation_text();
  std::string mesh_text() const;
  void write_materials();

  const MovingSurface* surface_;
  const ClipSpace* clip_;
  std::optional<ClipCamera> camera_;
  SplitVertices split_;
  FileWriter json_, numbers_;
  FloatPoints first_positions_, first_normals_;  // of the split vertices
  std::string views_, accessors_, attributes_, targets_, target_names_;
  struct Part {
    std::size_t material = 0;
    int indices = 0;  // accessor
  };
  std::vector<Part> parts_;  // of each material that triangles have
  int num_accessors_ = 0;
  std::vector<float> times_;
};

}  // namespace umax
