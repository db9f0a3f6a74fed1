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

constexpr int preview_bounces = 1;
// [px] that a preview's filter draws from: with so few paths a larger window takes longer and shows hardly less noise
constexpr int preview_radius = 3;

// that a filter looks at: they share one sequence of samples, so that all of them together are spread well, and what stands
// still is drawn from the same samples in every frame
constexpr int filter_frames = 5;
// of pixels that edges cross while the shutter is open: other frames help with all others, but not with the shape of what
// moves
constexpr int edge_samples = 16;
// [px] that the filter draws from once light was gathered over frames: little noise is left
constexpr int gathered_radius = 4;

PathTraceOptions trace_options(const RenderDescription& render, std::optional<int> frame) {
  PathTraceOptions options;
  options.width = render.width;
  options.height = render.height;
  options.samples = render.preview ? std::min(render.samples, preview_paths) : render.samples;
  options.noise = render.preview ? 0 : render.noise;
  options.bounces = render.preview ? std::min(render.bounces, preview_bounces) : render.bounces;
  options.seed = render.seed;
  if (frame) {
    options.block = (*frame % filter_frames + filter_frames) % filter_frames;
    options.blocks = filter_frames;
    options.edge_samples = edge_samples;
  }
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
  const CameraView view = view_at_moment(shot, render.width, render.height);
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

void add_layers(const TracedShot& shot, const RenderDescription& render, TracedImage& traced, TracedPicture& picture) {
  const auto add = [&](PictureLayer layer, const char* name, Image& image) {
    if (render.has_layer(layer)) picture.layers.push_back({name, std::move(image)});
  };
  SurfaceData data = *shot.data;
  add(PictureLayer::albedo, "Albedo", traced.albedo);
  add(PictureLayer::normal, "N", traced.normal);
  add(PictureLayer::depth, "Z", data.depth);
  add(PictureLayer::position, "P", data.position);
  add(PictureLayer::vector, "Vector", data.motion);
  add(PictureLayer::object, "Object.X", data.object);
  add(PictureLayer::energy, "EnergyRatio.X", data.value);
  add(PictureLayer::noise, "variance.X", traced.variance);
  add(PictureLayer::noise, "samples.X", traced.samples);
  describe(shot.shot, render, picture.header);
}

/// Where something is seen through a surface other frames do not help either.
void mark_clear(const std::vector<Hit>& hits, const RenderScene& shot, std::vector<char>& edges) {
  for (std::size_t i = 0; i < hits.size(); ++i)
    if (hits[i].found() && shot.objects[hits[i].object].look.transmission > 0) edges[i] = 1;
}

/// Few paths do not make up for the time that a good hierarchy takes. Rays meet the same in both.
HierarchyBuild hierarchy_for(const RenderScene& shot, const RenderDescription& render) {
  constexpr double paths_per_triangle = 12;
  double triangles = 0;
  for (const RenderObject& object : shot.objects) triangles += double(object.mesh->num_triangles());
  const double paths = double(render.width) * render.height * render.samples;
  return render.preview || paths < paths_per_triangle * triangles ? HierarchyBuild::fast : HierarchyBuild::good;
}

}  // namespace

Image filter_gathered(const TracedImage& image, const std::vector<const ClipFrame*>& window, std::size_t centre) {
  return denoise(image, gather_light(window, centre), {.radius = gathered_radius});
}

TracedShot trace_shot(RenderScene shot, const RenderDescription& render, std::optional<int> frame,
                      ClusterCache* clusters) {
  const RayScene rays(shot, hierarchy_for(shot, render), clusters);
  PathTraceOptions options = trace_options(render, frame);
  TracedShot traced;
  if (render.has_layer(PictureLayer::cryptomatte)) {
    Parts parts = parts_of(shot);
    options.mattes = std::move(parts.numbers);
    traced.object_names = std::move(parts.objects);
    traced.material_names = std::move(parts.materials);
  }
  traced.is_cut_out = shot.transparent || has_shadow_catchers(shot);
  std::vector<Hit> hits;
  if (frame) {
    hits = find_first_hits(rays, shot, render.width, render.height);
    options.edges = find_swept_edges(rays, shot, hits, render.width, render.height);
    mark_clear(hits, shot, options.edges);
  }
  traced.image = path_trace(rays, traced.is_cut_out ? made_transparent(shot) : shot, options);
  if (stop_flag()) return traced;
  if (frame) {
    traced.frame = make_clip_frame(hits, shot, traced.image, options.edges);
    traced.image.color = traced.image.half = {};  // which the clip's frame has; several wait for their turn
  }
  if (!render.layers.empty()) traced.data = find_surface_data(rays, shot, render.width, render.height);
  traced.shot = std::move(shot);
  return traced;
}

TracedPicture finish_picture(TracedShot& traced, const RenderDescription& render,
                             const std::vector<const ClipFrame*>& window, std::size_t centre) {
  TracedPicture picture;
  const bool denoised = render.denoise != NoiseFilter::none;
  TracedImage& image = traced.image;
  if (traced.is_cut_out)
    finish_cut_out(traced.shot, trace_options(render, {}), denoised, image);
  else if (traced.frame)
    image.color = filter_gathered(image, window, centre);
  else if (denoised)
    image.color = render.preview ? denoise(image, {.radius = preview_radius}) : denoise(image);
  if (stop_flag()) return picture;
  const bool has_layers = !render.layers.empty();
  if (has_layers && !render.transparent) std::fill(image.alpha.values.begin(), image.alpha.values.end(), 1.0f);
  const bool has_alpha = has_layers || render.transparent;
  picture.layers.push_back({"", has_alpha ? with_alpha(image.color, image.alpha) : std::move(image.color)});
  const std::vector<Image> mattes = std::move(image.mattes);
  if (has_layers)
    add_layers(traced, render, image, picture);
  else if (render.exr)
    add_guides(image, render, picture);
  if (!mattes.empty()) {
    add_cryptomatte("CryptoObject", traced.object_names, mattes[0], picture);
    add_cryptomatte("CryptoMaterial", traced.material_names, mattes[1], picture);
  }
  return picture;
}

}  // namespace umax
