#include "tools/pictures/traced_picture.h"

#include <algorithm>
#include <utility>

#include "render/image/cryptomatte.h"
#include "render/scene/camera.h"
#include "render/trace/cut_out.h"
#include "render/trace/denoise.h"
#include "render/trace/path_trace.h"
#include "render/trace/surface_data.h"
#include "tools/system/signals.h"

namespace umax {
namespace {

// of a preview
constexpr int preview_samples = 4, preview_bounces = 1;

PathTraceOptions trace_options(const RenderDescription& render) {
  PathTraceOptions options;
  options.width = render.width;
  options.height = render.height;
  options.samples = render.preview ? std::min(render.samples, preview_samples) : render.samples;
  options.noise = render.preview ? 0 : render.noise;
  options.bounces = render.preview ? std::min(render.bounces, preview_bounces) : render.bounces;
  options.seed = render.seed;
  options.stop = &stop_flag();
  return options;
}

/// Two ways to part a shot: by objects, and by materials, whose names objects may share.
struct Parts {
  std::vector<std::string> objects, materials;
  std::vector<PartNumbers> numbers = std::vector<PartNumbers>(2);
};

Parts parts_of(const RenderScene& shot) {
  Parts parts;
  for (const RenderObject& object : shot.objects) {
    parts.objects.push_back(object.name);
    std::vector<float> of_object, of_material;
    for (const Paint& paint : object.paints()) {
      parts.materials.push_back(paint.name.empty() ? object.name : paint.name);
      of_object.push_back(cryptomatte_number(object.name));
      of_material.push_back(cryptomatte_number(parts.materials.back()));
    }
    parts.numbers[0].push_back(std::move(of_object));
    parts.numbers[1].push_back(std::move(of_material));
  }
  return parts;
}

void add_cryptomatte(const std::string& name, const std::vector<std::string>& names, const Image& pairs,
                     TracedPicture& picture) {
  for (Layer& layer : cryptomatte_layers(name, pairs)) picture.layers.push_back(std::move(layer));
  for (auto& text : cryptomatte_texts(name, names)) picture.header.texts.push_back(std::move(text));
}

Image with_alpha(const Image& color, const Image& alpha) {
  Image both(color.width, color.height, 4);
  for (int y = 0; y < color.height; ++y)
    for (int x = 0; x < color.width; ++x) {
      std::copy_n(color.pixel(x, y), 3, both.pixel(x, y));
      both.pixel(x, y)[3] = *alpha.pixel(x, y);
    }
  return both;
}

/// The camera for column vectors: right, up and forward from it.
Eigen::Matrix4f camera_matrix(const CameraView& view) {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  const Vector3f* axes[] = {&view.right, &view.up, &view.forward};
  for (int i = 0; i < 3; ++i) {
    matrix.block<1, 3>(i, 0) = axes[i]->transpose();
    matrix(i, 3) = -axes[i]->dot(view.position);
  }
  return matrix;
}

/// From the world to the picture; its third number is the depth.
Eigen::Matrix4f picture_matrix(const CameraView& view, int width, int height) {
  const float pixel = view.step_x.norm();
  Eigen::Matrix4f picture = Eigen::Matrix4f::Zero();
  picture(0, 0) = 1 / (pixel * float(width));
  picture(1, 1) = -1 / (pixel * float(height));
  picture(0, 2) = picture(1, 2) = 0.5f;
  picture(2, 2) = picture(3, 2) = 1;
  return picture * camera_matrix(view);
}

void describe(const RenderScene& shot, const RenderDescription& render, ExrHeader& header) {
  std::vector<CameraView> views;
  for (const Camera& camera : shot.camera_path) views.push_back(make_camera_view(camera, render.width, render.height));
  const CameraView view =
      views.size() < 2 ? make_camera_view(shot.camera, render.width, render.height) : camera_at(views, shot.moment);
  header.is_rec709 = true;
  header.world_to_camera = camera_matrix(view);
  header.world_to_ndc = picture_matrix(view, render.width, render.height);
}

/// What scenes without render.layers get.
void add_guides(TracedImage& traced, const RenderDescription& render, TracedPicture& picture) {
  picture.layers.push_back({"Albedo", std::move(traced.albedo)});
  picture.layers.push_back({"N", std::move(traced.normal)});
  picture.layers.push_back({"Z", std::move(traced.depth)});
  picture.layers.push_back({"variance", std::move(traced.variance)});
  if (render.noise > 0) picture.layers.push_back({"samples", std::move(traced.samples)});
}

void add_layers(const RayScene& rays, const RenderScene& shot, const RenderDescription& render, TracedImage& traced,
                TracedPicture& picture) {
  const auto add = [&](PictureLayer layer, const char* name, Image& image) {
    if (render.has_layer(layer)) picture.layers.push_back({name, std::move(image)});
  };
  SurfaceData data = find_surface_data(rays, shot, render.width, render.height);
  add(PictureLayer::albedo, "Albedo", traced.albedo);
  add(PictureLayer::normal, "N", traced.normal);
  add(PictureLayer::depth, "Z", data.depth);
  add(PictureLayer::position, "P", data.position);
  add(PictureLayer::vector, "Vector", data.motion);
  add(PictureLayer::object, "Object.X", data.object);
  add(PictureLayer::energy, "EnergyRatio.X", data.value);
  add(PictureLayer::noise, "variance.X", traced.variance);
  add(PictureLayer::noise, "samples.X", traced.samples);
  describe(shot, render, picture.header);
}

}  // namespace

TracedPicture trace_picture(const RenderScene& shot, const RenderDescription& render) {
  const RayScene rays(shot, render.preview ? HierarchyBuild::fast : HierarchyBuild::good);
  PathTraceOptions options = trace_options(render);
  Parts parts;
  if (render.has_layer(PictureLayer::cryptomatte)) {
    parts = parts_of(shot);
    options.mattes = parts.numbers;
  }
  const bool is_cut_out = shot.transparent || has_shadow_catchers(shot);
  TracedImage traced = path_trace(rays, is_cut_out ? made_transparent(shot) : shot, options);
  TracedPicture picture;
  if (stop_flag()) return picture;
  if (is_cut_out)
    finish_cut_out(shot, options, render.denoise, traced);
  else if (render.denoise)
    traced.color = denoise(traced);
  if (stop_flag()) return picture;
  const bool has_layers = !render.layers.empty();
  if (has_layers && !render.transparent) std::fill(traced.alpha.values.begin(), traced.alpha.values.end(), 1.0f);
  const bool has_alpha = has_layers || render.transparent;
  picture.layers.push_back({"", has_alpha ? with_alpha(traced.color, traced.alpha) : std::move(traced.color)});
  if (has_layers)
    add_layers(rays, shot, render, traced, picture);
  else if (render.exr)
    add_guides(traced, render, picture);
  if (!options.mattes.empty()) {
    add_cryptomatte("CryptoObject", parts.objects, traced.mattes[0], picture);
    add_cryptomatte("CryptoMaterial", parts.materials, traced.mattes[1], picture);
  }
  return picture;
}

}  // namespace umax
