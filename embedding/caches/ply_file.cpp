#include "embedding/caches/ply_file.h"

#include <fmt/format.h>

#include <vector>

#include "core/base/srgb.h"
#include "embedding/caches/bytes.h"

namespace umax {
namespace {

std::string header_of(const MovingSurface& surface, const SurfaceFrame& frame) {
  std::string text = fmt::format("ply\nformat binary_little_endian 1.0\ncomment {}, frame {}, {} s\n", surface.name,
                                 frame.frame, frame.time);
  for (const std::string& texture : surface.textures()) text += "comment TextureFile " + texture + "\n";
  text += fmt::format("element vertex {}\n", surface.num_vertices());
  for (const char* name : {"x", "y", "z"}) text += fmt::format("property float {}\n", name);
  if (frame.normals.rows() > 0)
    for (const char* name : {"nx", "ny", "nz"}) text += fmt::format("property float {}\n", name);
  if (surface.texture_coordinates.rows() > 0)
    for (const char* name : {"s", "t"}) text += fmt::format("property float {}\n", name);
  if (frame.velocities.rows() > 0)
    for (const char* name : {"vx", "vy", "vz"}) text += fmt::format("property float {}\n", name);
  if (surface.colors.rows() > 0)
    for (const char* name : {"red", "green", "blue"}) text += fmt::format("property uchar {}\n", name);
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", surface.triangles.rows());
  if (surface.texture_coordinates.rows() > 0) text += "property list uchar float texcoord\n";
  return text + "end_header\n";
}

/// Of each vertex, the texture coordinate of its first corner.
std::vector<Eigen::RowVector2f> first_coordinates(const MovingSurface& surface) {
  std::vector<Eigen::RowVector2f> first(std::size_t(surface.num_vertices()), Eigen::RowVector2f::Zero());
  for (Eigen::Index corner = surface.texture_coordinates.rows() - 1; corner >= 0; --corner)
    first[std::size_t(surface.triangles(corner / 3, corner % 3))] = surface.texture_coordinates.row(corner);
  return first;
}

void append_vertices(std::string& out, const MovingSurface& surface, const SurfaceFrame& frame) {
  const std::vector<Eigen::RowVector2f> coordinates = first_coordinates(surface);
  const auto append_three = [&](const FloatPoints& values, Eigen::Index v) {
    if (values.rows() > 0)
      for (int axis = 0; axis < 3; ++axis) append_bytes(out, values(v, axis));
  };
  for (Eigen::Index v = 0; v < surface.num_vertices(); ++v) {
    append_three(frame.positions, v);
    append_three(frame.normals, v);
    if (surface.texture_coordinates.rows() > 0)
      for (int k = 0; k < 2; ++k) append_bytes(out, coordinates[std::size_t(v)][k]);
    append_three(frame.velocities, v);
    if (surface.colors.rows() > 0)
      for (int k = 0; k < 3; ++k) out += char(byte_from_unit(srgb_from_linear(surface.colors(v, k))));
  }
}

void append_faces(std::string& out, const MovingSurface& surface) {
  const bool has_texture = surface.texture_coordinates.rows() > 0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    out += char(3);
    for (int k = 0; k < 3; ++k) append_bytes(out, std::int32_t(surface.triangles(t, k)));
    if (!has_texture) continue;
    out += char(6);
    out.append(bytes_of(surface.texture_coordinates.middleRows<3>(3 * t).eval()));
  }
}

}  // namespace

std::string ply_bytes(const MovingSurface& surface, const SurfaceFrame& frame) {
  std::string out = header_of(surface, frame);
  append_vertices(out, surface, frame);
  append_faces(out, surface);
  return out;
}

}  // namespace umax
