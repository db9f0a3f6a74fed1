#include "embedding/caches/obj_file.h"

#include <fmt/format.h>

#include "core/base/srgb.h"
#include "embedding/caches/corner_values.h"
#include "embedding/caches/number_text.h"

namespace umax {
namespace {

/// Vertices with their colours, as the many programs take them that know colours in OBJ: sRGB behind the position.
void append_vertices(std::string& out, const MovingSurface& surface, const FloatPoints& positions) {
  const bool has_colors = surface.colors.rows() > 0;
  for (Eigen::Index v = 0; v < positions.rows(); ++v) {
    out += "v ";
    append_row(out, positions.row(v), " ");
    if (has_colors) {
      out += ' ';
      append_row(out, surface.colors.row(v).unaryExpr(&srgb_from_linear<float>).eval(), " ");
    }
    out += '\n';
  }
}

/// In the surface's order, with the material's name wherever it changes.
void append_faces(std::string& out, const MovingSurface& surface, const CornerValues& texture) {
  const Triangles& triangles = surface.triangles;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const std::size_t material = surface.material_of(t);
    if (t == 0 || material != surface.material_of(t - 1)) out += "usemtl " + surface.materials[material].name + "\n";
    out += 'f';
    for (int k = 0; k < 3; ++k) {
      out += ' ';
      append_number(out, triangles(t, k) + 1);
      if (texture.values.empty()) continue;
      out += '/';
      append_number(out, texture.index[std::size_t(3 * t + k)] + 1);
    }
    out += '\n';
  }
}

}  // namespace

std::string obj_text(const MovingSurface& surface, const FloatPoints& positions) {
  const CornerValues texture = distinct_values(surface.texture_coordinates);
  std::string out = "mtllib " + surface.library + "\no " + surface.name + "\n";
  append_vertices(out, surface, positions);
  for (const Eigen::RowVector2f& uv : texture.values) {
    out += "vt ";
    append_row(out, uv, " ");
    out += '\n';
  }
  out += "s 1\n";
  append_faces(out, surface, texture);
  return out;
}

std::string mtl_text(const MovingSurface& surface) {
  std::string text;
  for (const SurfaceMaterial& material : surface.materials) {
    const Vector3f& color = material.base_color;  // linear, as programs take Kd
    text += fmt::format("newmtl {}\nKd {} {} {}\nPr {}\nPm {}\nPc {}\nPcr {}\nNi {}\n", material.name, color.x(),
                        color.y(), color.z(), material.roughness, material.metallic, material.clearcoat,
                        material.clearcoat_roughness, material.ior);
    if (!material.texture.empty()) text += "map_Kd " + material.texture + "\n";
  }
  return text;
}

}  // namespace umax
