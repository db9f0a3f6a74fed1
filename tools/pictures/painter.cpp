#include "tools/pictures/painter.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "render/annotation/annotate.h"
#include "render/image/image_io.h"
#include "render/raster/rasterize.h"
#include "tools/pictures/traced_picture.h"
#include "tools/system/signals.h"

namespace umax {

struct Painter::Engine {
  std::optional<Rasterizer> rasterizer;
  int threads = 0;
  ClusterCache clusters;             // of meshes that move
  std::map<int, TracedShot> traced;  // by frame: what filters look at
};

namespace {

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

/// The colour alone or, of a transparent picture, with alpha and no longer multiplied by it.
Image shown_image(Image color, const RenderDescription& render) {
  if (color.channels < 4) return color;
  Image shown(color.width, color.height, render.transparent ? 4 : 3);
  for (int y = 0; y < color.height; ++y)
    for (int x = 0; x < color.width; ++x) {
      const float *from = color.pixel(x, y), alpha = from[3];
      float* to = shown.pixel(x, y);
      for (int c = 0; c < 3; ++c) to[c] = alpha > 0 ? from[c] / alpha : 0;
      if (render.transparent) to[3] = alpha;
    }
  return shown;
}

/// The picture's colour is used up.
DrawnPicture drawn_picture(TracedPicture& picture, const RenderDescription& render, const RenderScene& shot) {
  DrawnPicture drawn;
  drawn.linear = shown_image(std::move(picture.layers.front().image), render);
  drawn.shown = present(drawn.linear, shot);
  return drawn;
}

}  // namespace

void require_engine(const RenderDescription& render) {
  if (render.engine == RenderEngine::osmesa) require_rasterizer();
}

Painter::Painter(const RenderDescription& render, int threads) : render_(render), engine_(std::make_unique<Engine>()) {
  engine_->threads = threads;
  if (render.engine == RenderEngine::osmesa) engine_->rasterizer.emplace(threads);
}

Painter::~Painter() = default;

bool Painter::paint(const RenderScene& shot, const std::filesystem::path& png) {
  return make(shot, [&](TracedPicture& picture, const RenderScene& drawn) { write(picture, drawn, png); });
}

bool Painter::paint(const PictureList& list, int frame, const std::filesystem::path& png) {
  return make(list, frame, [&](TracedPicture& picture, const RenderScene& drawn) { write(picture, drawn, png); });
}

std::optional<DrawnPicture> Painter::draw(const RenderScene& shot) {
  std::optional<DrawnPicture> drawn;
  make(shot, [&](TracedPicture& picture, const RenderScene& of) { drawn = drawn_picture(picture, render_, of); });
  return drawn;
}

std::optional<DrawnPicture> Painter::draw(const PictureList& list, int frame) {
  std::optional<DrawnPicture> drawn;
  make(list, frame,
       [&](TracedPicture& picture, const RenderScene& of) { drawn = drawn_picture(picture, render_, of); });
  return drawn;
}

bool Painter::make(const RenderScene& shot, const Use& use) {
  TracedPicture picture;
  if (render_.engine == RenderEngine::embree) {
    TracedShot traced = trace_shot(shot, render_, {}, &engine_->clusters);
    if (stop_flag()) return false;
    picture = finish_picture(traced, render_, {}, 0);
  } else {
    picture.layers.push_back({"", engine_->rasterizer->draw(shot, raster_options(render_, engine_->threads))});
  }
  if (picture.layers.empty()) return false;
  use(picture, shot);
  return true;
}

bool Painter::make(const PictureList& list, int frame, const Use& use) {
  const FrameWindow window = list.window(frame);
  if (window.first == window.last) return make(list.shot(frame), use);
  std::map<int, TracedShot>& traced = engine_->traced;
  traced.erase(traced.begin(), traced.lower_bound(window.first));
  traced.erase(traced.upper_bound(window.last), traced.end());
  std::vector<const ClipFrame*> frames;
  for (int k = window.first; k <= window.last; ++k) {
    if (!traced.count(k)) {
      const bool is_drawn = std::binary_search(list.frames.begin(), list.frames.end(), k);
      TracedShot shot = trace_shot(is_drawn ? list.shot(k) : list.beside(k), render_, k, &engine_->clusters);
      if (stop_flag()) return false;
      traced.emplace(k, std::move(shot));
    }
    if (const auto& of_frame = traced.at(k).frame) frames.push_back(&*of_frame);
  }
  TracedShot& centre = traced.at(frame);
  TracedPicture picture = finish_picture(centre, render_, frames, std::size_t(frame - window.first));
  const bool is_whole = !picture.layers.empty();
  if (is_whole) use(picture, centre.shot);
  // its neighbours to come need no more of it
  centre.image = {};
  centre.shot = {};
  centre.data.reset();
  centre.frame->places = {};
  return is_whole;
}

void Painter::write(TracedPicture& picture, const RenderScene& shot, const std::filesystem::path& png) const {
  if (render_.writes_exr()) {
    std::filesystem::path exr = png;
    write_exr(exr.replace_extension(".exr"), picture.layers, picture.header);
  }
  write_png(png, drawn_picture(picture, render_, shot).shown,
            render_.preview ? PngEffort::little_time : PngEffort::small_file);
}

}  // namespace umax
