#include "render/trace/cut_out.h"

#include <algorithm>

#include "core/base/srgb.h"
#include "render/scene/camera.h"
#include "render/scene/light.h"
#include "render/trace/denoise.h"

namespace umax {
namespace {

float luminance_of(const float* p) {
  return luminance(p[0], p[1], p[2]);
}

TracedImage trace_catchers_alone(const RenderScene& scene, PathTraceOptions options) {
  RenderScene alone = scene;
  std::erase_if(alone.objects, [](const RenderObject& object) { return !object.catches_shadows; });
  options.mattes.clear();
  options.recording = nullptr;
  options.on_progress = {};
  return path_trace(alone, options);
}

/// share * (1 - L / L0); both lights are means over all paths of a pixel.
float shadow_of(float light, float share, float free_light, float free_share) {
  if (!(free_light > 0) || !(share > 0)) return 0;
  return std::clamp(share - light * free_share / free_light, 0.0f, share);
}

/// The share of each pixel that is in shadow, as a picture with what a filter needs.
TracedImage shadows_of(const TracedImage& traced, const TracedImage& alone) {
  TracedImage shadows = traced;
  std::fill(shadows.albedo.values.begin(), shadows.albedo.values.end(), 1.0f);
  const CaughtImage &here = *traced.caught, &free = *alone.caught;
  for (std::size_t i = 0; i < here.share.values.size(); ++i) {
    const float share = here.share.values[i], free_share = free.share.values[i];
    const float free_light = luminance_of(&free.light.values[3 * i]);
    const float shadow = shadow_of(luminance_of(&here.light.values[3 * i]), share, free_light, free_share);
    const float half =
        shadow_of(luminance_of(&here.half.values[3 * i]), share, luminance_of(&free.half.values[3 * i]), free_share);
    for (int c = 0; c < 3; ++c) {
      shadows.color.values[3 * i + c] = shadow;
      shadows.half.values[3 * i + c] = half;
    }
    const float scale = free_light > 0 ? free_share / free_light : 0;
    shadows.variance.values[i] = (traced.variance.values[i] + alone.variance.values[i]) * scale * scale;
  }
  return shadows;
}

/// What the camera sees behind everything, in the middle of each pixel.
Image background_of(const RenderScene& scene, const PathTraceOptions& options) {
  const Crop whole{.x0 = 0, .y0 = 0, .x1 = options.width, .y1 = options.height}, crop = options.crop.value_or(whole);
  Image background(crop.x1 - crop.x0, crop.y1 - crop.y0);
  const SkyLight sky(scene.sky);
  const CameraView view = make_camera_view(scene.camera, options.width, options.height);
  for (int y = 0; y < background.height; ++y)
    for (int x = 0; x < background.width; ++x) {
      const Ray ray = camera_ray(view, float(crop.x0 + x) + 0.5f, float(crop.y0 + y) + 0.5f, {0, 0});
      const Vector3f light = scene.backdrop ? *scene.backdrop : sky.radiance(ray.direction);
      std::copy_n(light.data(), 3, background.pixel(x, y));
    }
  return background;
}

/// Takes catchers out of the picture, its half and alpha.
void remove_caught(TracedImage& traced) {
  const CaughtImage& caught = *traced.caught;
  for (std::size_t i = 0; i < traced.color.values.size(); ++i) {
    traced.color.values[i] = std::max(0.0f, traced.color.values[i] - caught.light.values[i]);
    traced.half.values[i] = std::max(0.0f, traced.half.values[i] - caught.half.values[i]);
  }
  for (std::size_t i = 0; i < traced.alpha.values.size(); ++i)
    traced.alpha.values[i] = std::max(0.0f, traced.alpha.values[i] - caught.share.values[i]);
}

/// What guides the filter, of the part of each pixel that is seen: what is not covered has counted as white, without a
/// normal, and catchers as what they are.
void straighten_guides(const TracedImage& traced, TracedImage& straight) {
  for (std::size_t i = 0; i < traced.alpha.values.size(); ++i) {
    const float share = traced.alpha.values[i], caught = traced.caught ? traced.caught->share.values[i] : 0,
                nothing = std::max(0.0f, 1 - share - caught);
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
      const float albedo = traced.albedo.values[k] - (traced.caught ? traced.caught->albedo.values[k] : 0) - nothing;
      const float normal = traced.normal.values[k] - (traced.caught ? traced.caught->normal.values[k] : 0);
      straight.albedo.values[k] = share > 0 ? std::max(0.0f, albedo / share) : 1;
      straight.normal.values[k] = share > 0 ? normal / share : 0;
    }
    const float depth =
        traced.depth.values[i] * (share + caught) - (traced.caught ? traced.caught->depth.values[i] : 0);
    straight.depth.values[i] = share > 0 ? std::max(0.0f, depth / share) : 0;
  }
}

/// The filter sees what covers a part of its pixel as if it covered all, and nothing else: so its edge neither fades nor
/// spills over.
Image denoised_cut_out(const TracedImage& traced) {
  TracedImage straight = traced;
  straighten_guides(traced, straight);
  for (std::size_t i = 0; i < traced.alpha.values.size(); ++i) {
    const float share = traced.alpha.values[i];
    for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) {
      straight.color.values[k] = share > 0 ? traced.color.values[k] / share : 0;
      straight.half.values[k] = share > 0 ? traced.half.values[k] / share : 0;
    }
    // the paths' variance is of what is behind it, too: at edges the two halves tell
    const float apart = luminance_of(&straight.color.values[3 * i]) - luminance_of(&straight.half.values[3 * i]);
    if (share < 1) straight.variance.values[i] = apart * apart;
  }
  Image color = denoise(straight);
  for (std::size_t i = 0; i < color.values.size(); ++i) color.values[i] *= traced.alpha.values[i / 3];
  return color;
}

void lay_over(const Image& background, TracedImage& traced) {
  for (std::size_t i = 0; i < traced.color.values.size(); ++i)
    traced.color.values[i] += (1 - traced.alpha.values[i / 3]) * background.values[i];
}

}  // namespace

RenderScene made_transparent(RenderScene scene) {
  scene.transparent = true;
  return scene;
}

void finish_cut_out(const RenderScene& scene, const PathTraceOptions& options, bool denoised, TracedImage& traced) {
  Image shadow;
  if (traced.caught) {
    const TracedImage alone = trace_catchers_alone(scene, options);
    if (options.stop && options.stop->load(std::memory_order_relaxed)) return;
    const TracedImage shadows = shadows_of(traced, alone);
    shadow = denoised ? denoise(shadows) : shadows.color;
    remove_caught(traced);
  }
  if (denoised) traced.color = denoised_cut_out(traced);
  for (std::size_t i = 0; i < traced.alpha.values.size() && traced.caught; ++i)
    traced.alpha.values[i] = std::clamp(traced.alpha.values[i] + shadow.values[3 * i], 0.0f, 1.0f);
  if (!scene.transparent) lay_over(background_of(scene, options), traced);
}

}  // namespace umax
