#include "render/trace/traced_object.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"

namespace umax {
namespace {

[[noreturn]] void throw_bad_mesh(const RenderObject& object, const std::string& what, Eigen::Index row) {
  throw Error(Fault::bad_data, {.where = "object " + object.name,
                                .what = what,
                                .value = "row " + std::to_string(row),
                                .remedy = "repair the mesh"});
}

void copy_vertices(const RenderObject& object, const TriangleMesh& mesh, TracedObject::Vertex* vertices,
                   bool has_normals) {
  for (Eigen::Index i = 0; i < mesh.num_vertices(); ++i) {
    for (int c = 0; c < 3; ++c) {
      vertices[i].position[c] = float(mesh.positions(i, c));
      vertices[i].normal[c] = has_normals ? float(mesh.normals(i, c)) : 0.0f;
    }
    const float* p = vertices[i].position;
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
      throw_bad_mesh(object, "a vertex is not finite", i);
  }
}

bool has_normals(const TriangleMesh& mesh) {
  return mesh.normals.rows() == mesh.num_vertices() && mesh.num_vertices() > 0;
}

void copy_all_vertices(const RenderObject& object, TracedObject& traced) {
  std::vector<const TriangleMesh*> instants;
  for (const auto& instant : object.motion.instants) instants.push_back(instant.get());
  if (instants.size() < 2) instants = {object.mesh.get()};
  traced.instants = {.num_instants = int(instants.size()),
                     .first = object.motion.first,
                     .segments_per_time = float(instants.size() - 1) / (object.motion.last - object.motion.first)};
  traced.num_vertices = std::size_t(object.mesh->num_vertices());
  traced.has_normals =
      std::all_of(instants.begin(), instants.end(), [](const auto* mesh) { return has_normals(*mesh); });
  traced.vertices.resize(instants.size() * traced.num_vertices);
  for (std::size_t k = 0; k < instants.size(); ++k) {
    if (instants[k]->num_vertices() != object.mesh->num_vertices())
      throw_bad_mesh(object, "an instant of its motion has another number of vertices", Eigen::Index(k));
    copy_vertices(object, *instants[k], traced.vertices.data() + k * traced.num_vertices, traced.has_normals);
  }
}

void copy_triangles(const RenderObject& object, TracedObject& traced) {
  const TriangleMesh& mesh = *object.mesh;
  traced.triangles.resize(mesh.num_triangles());
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const int index = mesh.triangles(t, c);
      if (index < 0 || index >= mesh.num_vertices()) throw_bad_mesh(object, "a triangle has a corner too many", t);
      traced.triangles[t].index[c] = unsigned(index);
    }
  }
}

void copy_paints(const RenderObject& object, TracedObject& traced) {
  traced.paints = object.paints();
  if (!object.has_paints()) return;
  traced.paint = object.mesh->materials;
  for (std::size_t t = 0; t < traced.paint.size(); ++t)
    if (traced.paint[t] < 0 || traced.paint[t] >= int(traced.paints.size()))
      throw_bad_mesh(object, "a triangle has a material too many", Eigen::Index(t));
}

void copy_colors(const RenderObject& object, TracedObject& traced) {
  const TriangleMesh& mesh = *object.mesh;
  copy_paints(object, traced);
  if (object.look.vertex_colors && mesh.colors.rows() == mesh.num_vertices()) {
    traced.colors.resize(mesh.num_vertices());
    for (Eigen::Index i = 0; i < mesh.num_vertices(); ++i)
      traced.colors[i] = mesh.colors.row(i).cast<float>().transpose();
  }
  bool has_texture = false;
  for (Paint& paint : traced.paints) {
    if (paint.texture && paint.texture->values.empty()) paint.texture = nullptr;
    has_texture |= paint.texture != nullptr;
  }
  if (has_texture && mesh.texture_coordinates.rows() == 3 * mesh.num_triangles()) {
    traced.texture_coordinates.resize(mesh.texture_coordinates.rows());
    for (Eigen::Index i = 0; i < mesh.texture_coordinates.rows(); ++i)
      traced.texture_coordinates[i] = mesh.texture_coordinates.row(i).transpose();
  }
}

// bilinear look-up, repeating; v runs upwards
Vector3f texture_color(const Image& image, const Vector2f& uv) {
  const float x = (uv.x() - std::floor(uv.x())) * float(image.width) - 0.5f;
  const float y = (1 - (uv.y() - std::floor(uv.y()))) * float(image.height) - 0.5f;
  const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
  const auto wrap = [](int i, int n) { return i < 0 ? i + n : i >= n ? i - n : i; };
  const auto texel = [&](int i, int j) {
    const float* p = image.pixel(wrap(i, image.width), wrap(j, image.height));
    return image.channels >= 3 ? Vector3f(p[0], p[1], p[2]) : Vector3f(p[0], p[0], p[0]);
  };
  const float fx = x - float(x0), fy = y - float(y0);
  return (1 - fy) * ((1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0)) +
         fy * ((1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1));
}

}  // namespace

TracedObject::Instant TracedObject::at(float time) const {
  if (!is_moving()) return {};
  const InstantTimes::Place place = instants.at(time);
  return {.before = std::size_t(place.segment) * num_vertices,
          .after = std::size_t(place.segment + 1) * num_vertices,
          .share = place.share};
}

Vector3f TracedObject::corner(unsigned triangle, int c, const Instant& instant) const {
  const unsigned index = triangles[triangle].index[c];
  const Vector3f before(vertices[instant.before + index].position);
  return is_moving() ? Vector3f((1 - instant.share) * before +
                                instant.share * Vector3f(vertices[instant.after + index].position))
                     : before;
}

Vector3f TracedObject::face(unsigned triangle, float time) const {
  const Instant instant = at(time);
  const Vector3f a = corner(triangle, 0, instant);
  return (corner(triangle, 1, instant) - a).cross(corner(triangle, 2, instant) - a);
}

Vector3f TracedObject::position_on(const Hit& hit, float time) const {
  const Instant instant = at(time);
  return (1 - hit.u - hit.v) * corner(hit.triangle, 0, instant) + hit.u * corner(hit.triangle, 1, instant) +
         hit.v * corner(hit.triangle, 2, instant);
}

Vector3f TracedObject::color_at(unsigned triangle, float first_share, float u, float v) const {
  const Paint& of_triangle = paints[paint.empty() ? 0 : std::size_t(paint[triangle])];
  Vector3f color = of_triangle.base_color;
  if (!colors.empty()) {
    const Corners& corners = triangles[triangle];
    color = first_share * colors[corners.index[0]] + u * colors[corners.index[1]] + v * colors[corners.index[2]];
  }
  if (of_triangle.texture && !texture_coordinates.empty()) {
    const Vector2f* uv = &texture_coordinates[3 * std::size_t(triangle)];
    color = color.cwiseProduct(texture_color(*of_triangle.texture, first_share * uv[0] + u * uv[1] + v * uv[2]));
  }
  return color;
}

TracedObject make_traced_object(const RenderObject& object) {
  TracedObject traced;
  copy_all_vertices(object, traced);
  copy_triangles(object, traced);
  copy_colors(object, traced);
  return traced;
}

}  // namespace umax
