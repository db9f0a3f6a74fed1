#include "tools/pictures/painter.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "render/annotation/annotate.h"
#include "render/image/image_io.h"
#include "render/raster/rasterize.h"
#include "render/trace/denoise.h"
#include "render/trace/path_trace.h"
#include "tools/system/signals.h"

namespace umax {

struct Painter::Engine {
  std::optional<Rasterizer> rasterizer;
  int threads = 0;
};

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

/// Colour first, then what a compositor wants; nothing when a signal asks us to stop.
std::vector<Layer> trace_layers(const RenderScene& shot, const RenderDescription& render) {
  const RayScene rays(shot, render.preview ? HierarchyBuild::fast : HierarchyBuild::good);
  TracedImage traced = path_trace(rays, shot, trace_options(render));
  std::vector<Layer> layers;
  if (stop_flag()) return layers;
  DenoiseOptions filter;
  if (render.denoise) traced.color = denoise(traced, filter);
  layers.push_back({"", std::move(traced.color)});
  layers.push_back({"Albedo", std::move(traced.albedo)});
  layers.push_back({"N", std::move(traced.normal)});
  layers.push_back({"Z", std::move(traced.depth)});
  layers.push_back({"variance", std::move(traced.variance)});
  if (render.noise > 0) layers.push_back({"samples", std::move(traced.samples)});
  return layers;
}

/// Few samples mean few shadow maps, too: in proportion, and from 16 on all that the rasteriser has by itself.
RasterizeOptions raster_options(const RenderDescription& render, int threads) {
  const RasterizeOptions whole;
  const auto share = [&](int maps) { return std::min(maps, (maps * render.samples + 15) / 16); };
  return {.width = render.width,
          .height = render.height,
          .light_samples = share(whole.light_samples),
          .sky_samples = std::max(8, share(whole.sky_samples)),
          .threads = threads};
}

}  // namespace

Painter::Painter(const RenderDescription& render, int threads) : render_(render), engine_(std::make_unique<Engine>()) {
  engine_->threads = threads;
  if (render.engine == RenderEngine::osmesa) engine_->rasterizer.emplace(threads);
}

Painter::~Painter() = default;

bool Painter::paint(const RenderScene& shot, const std::filesystem::path& png) {
  std::vector<Layer> layers;
  if (render_.engine == RenderEngine::embree)
    layers = trace_layers(shot, render_);
  else
    layers.push_back({"", engine_->rasterizer->draw(shot, raster_options(render_, engine_->threads))});

  if (layers.empty()) return false;
  if (render_.exr) {
    std::filesystem::path exr = png;
    write_exr(exr.replace_extension(".exr"), layers);
  }
  write_png(png, present(layers.front().image, shot));
  return true;
}

}  // namespace umax
