#include "tools/setup/body_look.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "embedding/surface/mesh_report.h"
#include "render/image/image_io.h"

namespace umax {
namespace {

bool is_same(const ShapeLibrary::Texture& a, const ShapeLibrary::Texture& b) {
  return a.path == b.path && a.own == b.own && a.place == b.place;
}

Image read(const ShapeLibrary::Texture& wanted) {
  if (!wanted.own) return read_image(wanted.path);
  return decode_image(wanted.own->embedded_textures[std::size_t(wanted.place)],
                      fmt::format("picture {} inside the mesh file", wanted.place + 1));
}

/// The picture, read unless the library has it; null where it cannot be read, which is said once.
std::shared_ptr<const Image> find_or_read(ShapeLibrary::Texture wanted, ShapeLibrary& library,
                                          std::vector<std::string>& warnings, const std::string& body) {
  const auto found = std::find_if(library.textures.begin(), library.textures.end(),
                                  [&](const ShapeLibrary::Texture& texture) { return is_same(texture, wanted); });
  if (found != library.textures.end()) return found->image;
  try {
    wanted.image = std::make_shared<const Image>(read(wanted));
  } catch (const Error& error) {
    warnings.push_back(fmt::format("body.{}: {}; drawn in the plain colour", body, error.what()));
  }
  library.textures.push_back(wanted);
  return wanted.image;
}

std::shared_ptr<const Image> texture_of(const MeshMaterial& material, const BodyDescription& body,
                                        const PlacedMesh& shape, ShapeLibrary& library,
                                        std::vector<std::string>& warnings) {
  if (!material.has_texture() || shape.mesh.texture_coordinates.rows() == 0) return nullptr;
  ShapeLibrary::Texture wanted{.path = material.texture, .own = nullptr, .place = -1, .image = nullptr};
  if (material.embedded_texture >= 0) {
    wanted.own = shape.own.get();
    wanted.place = material.embedded_texture;
  }
  return find_or_read(wanted, library, warnings, body.name);
}

bool asks_for_color(const Look& look) {
  return look.base_color != Look().base_color;
}

Paint paint_of(const MeshMaterial& material, const Look& look, std::shared_ptr<const Image> texture) {
  Paint paint{look.base_color, std::move(texture), material.name};
  if (asks_for_color(look)) return paint;
  if (paint.texture)
    paint.base_color = material.texture_tint.cast<float>();
  else if (material.color)
    paint.base_color = material.color->cast<float>();
  return paint;
}

}  // namespace

Look drawable_look(Look look, const TriangleMesh* mesh, std::vector<std::string>& notes) {
  if (!look.lets_light_in()) return look;
  const MeshReport report = mesh ? report_mesh(*mesh) : MeshReport{};
  if (report.watertight && report.signed_volume > 0) return look;
  notes.push_back(fmt::format("the surface is {}, so no light gets into it: look.{} is drawn matt",
                              report.watertight ? "inside out" : "not closed",
                              look.transmission > 0 ? "transmission" : "subsurface"));
  look.transmission = look.subsurface = 0;
  return look;
}

Look body_look(const BodyDescription& body, const PlacedMesh& shape, ShapeLibrary& library,
               std::vector<std::string>& warnings) {
  std::vector<std::string> notes;
  Look look = drawable_look(body.look, &shape.mesh, notes);
  for (const std::string& note : notes) warnings.push_back(fmt::format("body.{}: {}", body.name, note));
  look.vertex_colors = shape.mesh.colors.rows() > 0 && !asks_for_color(look);
  if (!body.texture_path.empty()) {
    if (shape.mesh.texture_coordinates.rows() > 0)
      look.texture = find_or_read({body.texture_path, nullptr, -1, nullptr}, library, warnings, body.name);
    else
      warnings.push_back(
          fmt::format("body.{}: the mesh has no texture coordinates; look.texture is not used", body.name));
    return look;
  }
  for (const MeshMaterial& material : shape.own->materials)
    look.paints.push_back(paint_of(material, look, texture_of(material, body, shape, library, warnings)));
  if (look.paints.size() != 1) return look;
  look.base_color = look.paints[0].base_color;
  look.texture = look.paints[0].texture;
  look.material = look.paints[0].name;
  look.paints.clear();
  return look;
}

}  // namespace umax
