#include "render/raster/rasterize.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/srgb.h"
#include "render/raster/gl_raster.h"
#include "render/raster/raster_light.h"
#include "render/raster/raster_shade.h"
#include "render/scene/camera.h"

namespace umax {
namespace {

using raster::Frame;
using raster::Matrix4f;
using raster::Vector4f;

// ---- camera -----------------------------------------------------------------------------------------------------

Matrix4f view_from_world(const CameraView& camera) {
  Matrix4f view = Matrix4f::Identity();
  view.block<1, 3>(0, 0) = camera.right.transpose();
  view.block<1, 3>(1, 0) = camera.up.transpose();
  view.block<1, 3>(2, 0) = -camera.forward.transpose();
  view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * camera.position;
  return view;
}

Matrix4f clip_from_view(const Camera& camera, float aspect, float near_plane, float far_plane) {
  const float f = 1 / std::tan(camera.vertical_fov_degrees * std::numbers::pi_v<float> / 360);
  Matrix4f clip = Matrix4f::Zero();
  clip(0, 0) = f / aspect;
  clip(1, 1) = f;
  clip(2, 2) = (far_plane + near_plane) / (near_plane - far_plane);
  clip(2, 3) = 2 * far_plane * near_plane / (near_plane - far_plane);
  clip(3, 2) = -1;
  return clip;
}

// ---- geometry ---------------------------------------------------------------------------------------------------

Vector3f point(const TriangleMesh& mesh, Eigen::Index v) {
  return mesh.positions.row(v).transpose().cast<float>();
}

Vector3f base_color(const RenderObject& object, const Paint& paint, Eigen::Index v) {
  const TriangleMesh& mesh = *object.mesh;
  const bool painted = object.look.vertex_colors && mesh.colors.rows() == mesh.positions.rows();
  return painted ? Vector3f(mesh.colors.row(v).transpose().cast<float>()) : paint.base_color;
}

/// One vertex per mesh vertex: for meshes with normals and without texture.
void append_shared(const RenderObject& object, const Paint& paint, Frame& frame) {
  const TriangleMesh& mesh = *object.mesh;
  const auto first = std::uint32_t(frame.vertices.size());
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v)
    frame.vertices.push_back(
        {point(mesh, v), mesh.normals.row(v).transpose().cast<float>(), base_color(object, paint, v), {0, 0}});
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t)
    for (int c = 0; c < 3; ++c) frame.indices.push_back(first + std::uint32_t(mesh.triangles(t, c)));
}

/// One vertex per triangle corner: for flat shading, texture coordinates and meshes of several paints, of which those
/// triangles are taken that have this one.
void append_corners(const RenderObject& object, const Paint& paint, int material, Frame& frame) {
  const TriangleMesh& mesh = *object.mesh;
  const bool smooth = mesh.normals.rows() == mesh.num_vertices();
  const bool textured = mesh.texture_coordinates.rows() == 3 * mesh.num_triangles();
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    if (object.has_paints() && mesh.materials[std::size_t(t)] != material) continue;
    const auto corners = mesh.triangles.row(t);
    const Vector3f a = point(mesh, corners[0]), b = point(mesh, corners[1]), c = point(mesh, corners[2]);
    const Vector3f flat = (b - a).cross(c - a).normalized();
    for (int k = 0; k < 3; ++k) {
      const Vector3f normal = smooth ? Vector3f(mesh.normals.row(corners[k]).transpose().cast<float>()) : flat;
      Vector2f uv(0, 0);
      if (textured) uv = {mesh.texture_coordinates(3 * t + k, 0), 1 - mesh.texture_coordinates(3 * t + k, 1)};
      frame.indices.push_back(std::uint32_t(frame.vertices.size()));
      frame.vertices.push_back({point(mesh, corners[k]), normal, base_color(object, paint, corners[k]), uv});
    }
  }
}

raster::Batch batch_of(const RenderObject& object, bool is_ground) {
  const Look& look = object.look;
  const float reflectance = (look.ior - 1) / (look.ior + 1);
  raster::Batch batch;
  batch.roughness = std::clamp(look.roughness, 0.0f, 1.0f);
  batch.reflectance = reflectance * reflectance;
  batch.metallic = look.metallic;
  batch.coat = look.clearcoat;
  batch.coat_roughness = look.clearcoat_roughness;
  batch.transmission = look.transmission;
  batch.subsurface = (1 - look.transmission) * look.subsurface;
  batch.ior = look.ior;
  batch.is_ground = is_ground;
  return batch;
}

/// One batch for each of its paints.
void append_object(const RenderObject& object, bool is_ground, Frame& frame) {
  const TriangleMesh& mesh = *object.mesh;
  const bool has_coordinates = mesh.texture_coordinates.rows() == 3 * mesh.num_triangles();
  const std::vector<Paint> paints = object.paints();
  for (std::size_t material = 0; material < paints.size(); ++material) {
    raster::Batch batch = batch_of(object, is_ground);
    batch.first_index = int(frame.indices.size());
    if (has_coordinates) batch.texture = paints[material].texture;
    if (mesh.normals.rows() == mesh.num_vertices() && !batch.texture && !object.has_paints())
      append_shared(object, paints[material], frame);
    else
      append_corners(object, paints[material], int(material), frame);
    batch.num_indices = int(frame.indices.size()) - batch.first_index;
    if (batch.num_indices > 0) frame.batches.push_back(batch);
  }
}

// ---- what stands on what ----------------------------------------------------------------------------------------

struct Box {
  Vector3f low = Vector3f::Constant(INFINITY), high = Vector3f::Constant(-INFINITY);
  void add(const Vector3f& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool empty() const { return !(low[0] <= high[0]); }
  Vector3f center() const { return 0.5f * (low + high); }
  Vector3f size() const { return high - low; }
};

Box box_of(const TriangleMesh& mesh) {
  Box box;
  if (mesh.num_vertices() == 0) return box;
  box.low = mesh.positions.colwise().minCoeff().transpose().cast<float>();
  box.high = mesh.positions.colwise().maxCoeff().transpose().cast<float>();
  return box;
}

bool is_flat(const Box& box) {
  return !box.empty() && box.size()[1] <= 1e-3f * std::min(box.size()[0], box.size()[2]);
}

/// Bodies and obstacles, without the plane they stand on.
struct Arrangement {
  raster::Focus focus;
  raster::Ground ground;
  std::vector<bool> is_ground;  // per object
  std::optional<Fade> fade;
};

Arrangement arrange(const RenderScene& scene) {
  Arrangement result;
  Box things, all;
  for (const RenderObject& object : scene.objects) {
    const Box box = box_of(*object.mesh);
    if (box.empty()) continue;
    for (const Vector3f& corner : {box.low, box.high}) {
      all.add(corner);
      if (!is_flat(box)) things.add(corner);
    }
  }
  const Box& shown = things.empty() ? all : things;
  if (!shown.empty()) result.focus = {shown.center(), std::max(0.5f * shown.size().norm(), 1e-6f)};
  for (const RenderObject& object : scene.objects) {
    const Box box = box_of(*object.mesh);
    const float half = box.empty() ? 0 : 0.5f * std::min(box.size()[0], box.size()[2]);
    const bool ground = !things.empty() && is_flat(box) && half > 1.5f * result.focus.radius;
    result.is_ground.push_back(ground);
    if (!ground) continue;
    result.ground = {true, box.center()[1], base_color(object, object.paints().front(), 0)};
    // a wide plane fades into the horizon, if the scene does not say how; a small one ends where it ends
    if (object.fade)
      result.fade = object.fade;
    else if (half > 6 * result.focus.radius)
      result.fade = {.center = box.center(),
                     .begin = 1.5f * result.focus.radius,
                     .end = std::min(14 * result.focus.radius, 0.9f * half)};
  }
  return result;
}

// ---- wires ------------------------------------------------------------------------------------------------------

/// The quad around a segment, in clip space; ends are square, half a width beyond the end points.
void append_wire(Vector4f a, Vector4f b, const Vector2f& half_size, float reach, Frame& frame) {
  constexpr float smallest_w = 1e-4f;
  if (a[3] < smallest_w && b[3] < smallest_w) return;
  if (a[3] < smallest_w) a = b + (a - b) * ((b[3] - smallest_w) / (b[3] - a[3]));
  if (b[3] < smallest_w) b = a + (b - a) * ((a[3] - smallest_w) / (a[3] - b[3]));
  const auto pixels = [&](const Vector4f& p) { return Vector2f(p.head<2>().cwiseProduct(half_size) / p[3]); };
  const Vector2f span = pixels(b) - pixels(a);
  const Vector2f along = span.norm() > 1e-6f ? Vector2f(span.normalized()) : Vector2f(1, 0);
  const Vector2f across(-along[1], along[0]);
  const auto corner = [&](const Vector4f& p, float forth, float side) {
    const Vector2f offset =
        (forth * along * std::max(reach - 1, 0.0f) + side * across * reach).cwiseQuotient(half_size);
    return raster::WireVertex{{p[0] + offset[0] * p[3], p[1] + offset[1] * p[3], p[2], p[3]}, side * reach};
  };
  for (const auto& vertex :
       {corner(a, -1, -1), corner(b, 1, -1), corner(b, 1, 1), corner(a, -1, -1), corner(b, 1, 1), corner(a, -1, 1)})
    frame.wires.push_back(vertex);
}

void append_wires(const WireOverlay& overlay, int supersample, Frame& frame) {
  const float width = std::max(overlay.width_pixels, 0.0f) * float(supersample);
  frame.wire_color = overlay.color;
  frame.wire_half_width = 0.5f * std::max(width, 1.0f);
  frame.wire_opacity = std::min(width, 1.0f);  // thinner than a pixel: a pixel wide and fainter
  frame.hidden_wire_opacity = overlay.hidden_lines ? 0.22f * frame.wire_opacity : 0;
  const Vector2f half_size(0.5f * float(frame.width), 0.5f * float(frame.height));
  // a little towards the eye: wires on a surface lie in front of it
  const auto clip = [&](const Vector3f& p) {
    const Vector3f nearer = frame.eye + 0.998f * (p - frame.eye);
    return Vector4f(frame.clip_from_world * Vector4f(nearer[0], nearer[1], nearer[2], 1));
  };
  for (const auto& [a, b] : overlay.segments)
    append_wire(clip(a), clip(b), half_size, frame.wire_half_width + 1, frame);
}

// ---- the frame --------------------------------------------------------------------------------------------------

void set_camera(const Camera& camera, const Frame& drawn, const raster::Focus& focus, Frame& frame) {
  float farthest = (camera.position - focus.center).norm() + focus.radius;
  for (const raster::Vertex& vertex : drawn.vertices)
    farthest = std::max(farthest, (vertex.position - camera.position).norm());
  const float near_plane = std::max(1e-3f * (camera.position - camera.target).norm(), 1e-6f);
  const Matrix4f view = view_from_world(make_camera_view(camera, frame.width, frame.height));
  const float aspect = float(frame.width) / float(frame.height);
  frame.clip_from_world = clip_from_view(camera, aspect, near_plane, std::max(1.01f * farthest, 2 * near_plane)) * view;
  frame.world_from_clip = frame.clip_from_world.cast<double>().inverse().cast<float>();
  frame.eye = camera.position;
}

Image reduced(const Image& image, int factor) {
  if (factor == 1) return image;
  Image out(image.width / factor, image.height / factor, image.channels);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      float weights = 0;
      for (int i = 0; i < factor * factor; ++i) {
        const float* in = image.pixel(x * factor + i % factor, y * factor + i / factor);
        const float weight = 1 / (1 + std::max({in[0], in[1], in[2]}));  // as the samples of a pixel are weighted
        for (int c = 0; c < 3; ++c) out.pixel(x, y)[c] += weight * in[c];
        weights += weight;
      }
      for (int c = 0; c < 3; ++c) out.pixel(x, y)[c] /= weights;
    }
  }
  return out;
}

}  // namespace

struct Rasterizer::Resources {
  raster::GlRaster gl;
  raster::ProbeCache probe;
  explicit Resources(int threads) : gl(threads) {}
};

void require_rasterizer() {
  raster::require_os_mesa();
}

Rasterizer::Rasterizer(int threads) : resources_(std::make_unique<Resources>(threads)) {}
Rasterizer::~Rasterizer() = default;
Rasterizer::Rasterizer(Rasterizer&&) noexcept = default;
Rasterizer& Rasterizer::operator=(Rasterizer&&) noexcept = default;

Image Rasterizer::draw(const RenderScene& scene, const RasterizeOptions& options) {
  assert(options.width > 0 && options.height > 0 && options.supersample >= 1);
  Frame frame;
  frame.width = options.width * options.supersample;
  frame.height = options.height * options.supersample;
  const Arrangement arrangement = arrange(scene);
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    append_object(scene.objects[i], arrangement.is_ground[i], frame);
  frame.ground_fade = arrangement.fade;
  set_camera(scene.camera, frame, arrangement.focus, frame);
  raster::prepare_lighting(scene, arrangement.focus, arrangement.ground, {options.light_samples, options.sky_samples},
                           resources_->probe, frame);
  if (scene.wires) append_wires(*scene.wires, options.supersample, frame);
  return reduced(raster::shade(frame, resources_->gl.draw(frame)), options.supersample);
}

Image rasterize(const RenderScene& scene, const RasterizeOptions& options) {
  return Rasterizer(options.threads).draw(scene, options);
}

}  // namespace umax
