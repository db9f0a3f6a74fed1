#include "render/trace/path_trace.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <mutex>
#include <string>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "render/trace/caught_light.h"
#include "render/trace/enough_samples.h"
#include "render/trace/tile_parts.h"

namespace umax {
namespace {

constexpr int tile_size = 16;  // [px]

// Denormals cost Embree time. The setting is this thread's own and put back, so that no other computation meets it.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(saved_); }
#else
  FlushDenormals() = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

#if defined(__SSE2__)
 private:
  unsigned saved_;
#endif
};

bool lets_light_in(const RenderScene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [](const RenderObject& object) { return object.look.lets_light_in(); });
}

PathTracer make_tracer(const RayScene& rays, const RenderScene& scene, const PathTraceOptions& options) {
  const int in_sequence =
      options.noise > 0 ? (options.samples + 1) / 2 : std::max(options.samples, options.edge_samples);
  PathTracer tracer{.rays = rays,
                    .looks = {},
                    .matters = {},
                    .has_matter = lets_light_in(scene),
                    .shows_backdrop = !scene.transparent,
                    .lights = RectangleLights(scene.lights),
                    .sky = SkyLight(scene.sky),
                    .backdrop = scene.transparent ? Vector3f(0, 0, 0) : scene.backdrop,
                    .fades = {},
                    .cameras = {},
                    .has_shutter = false,
                    .keeps_parts = !options.mattes.empty() || has_shadow_catchers(scene),
                    .sequence = SampleSequence(in_sequence * options.blocks, options.seed),
                    .first_sample = in_sequence * options.block,
                    .filter = pixel_filter(),
                    .bounces = options.bounces};
  for (const RenderObject& object : scene.objects)
    tracer.looks.push_back(make_bsdf_look(object.look, "object " + object.name));
  for (const RenderObject& object : scene.objects)
    tracer.matters.push_back(make_matter(object.look, "object " + object.name));
  for (const RenderObject& object : scene.objects)
    if (has_fade(scene)) tracer.fades.push_back(object.catches_shadows ? std::nullopt : object.fade);
  for (const Camera& camera : scene.camera_path)
    tracer.cameras.push_back(make_camera_view(camera, options.width, options.height));
  if (tracer.cameras.size() < 2) tracer.cameras = {make_camera_view(scene.camera, options.width, options.height)};
  const auto moves = [](const RenderObject& object) { return object.motion.instants.size() > 1; };
  tracer.has_shutter = tracer.cameras.size() > 1 || std::any_of(scene.objects.begin(), scene.objects.end(), moves);
  return tracer;
}

// part of the picture that one thread traces at a time: columns and rows of what is kept
struct TileArea {
  int left, top, right, bottom;
};

// Paths on their way into sums, traced in waves.
class PathQueue {
 public:
  PathQueue(const PathTracer& tracer, const Crop& crop, std::vector<RecordedRay>* recording, TileParts& parts,
            CaughtLight& caught)
      : wave_(tracer), crop_(crop), recording_(recording), parts_(parts), caught_(caught) {}

  /// Samples `begin` to `end` - 1 of a pixel of the crop.
  void add(int column, int row, int stream, int begin, int end, PixelSum& sum) {
    for (int sample = begin; sample < end; ++sample) {
      starts_.push_back({.x = crop_.x0 + column, .y = crop_.y0 + row, .sample = sample, .stream = stream});
      sums_.push_back(&sum);
      if (starts_.size() == PathWave::max_paths) flush();
    }
  }

  void flush() {
    const PathResult* results = wave_.trace(starts_, recording_);
    for (std::size_t i = 0; i < starts_.size(); ++i) sums_[i]->add(results[i], starts_[i].sample);
    const FirstPart* parts = wave_.first_parts();
    for (std::size_t i = 0; i < starts_.size() && parts_.are_wanted(); ++i)
      parts_.add(starts_[i].x - crop_.x0, starts_[i].y - crop_.y0, starts_[i].stream, parts[i]);
    for (std::size_t i = 0; i < starts_.size() && caught_.is_wanted(); ++i)
      caught_.add(starts_[i].x - crop_.x0, starts_[i].y - crop_.y0, starts_[i], parts[i], results[i]);
    starts_.clear();
    sums_.clear();
  }

 private:
  PathWave wave_;
  Crop crop_;
  std::vector<RecordedRay>* recording_;
  TileParts& parts_;
  CaughtLight& caught_;
  std::vector<PathStart> starts_;
  std::vector<PixelSum*> sums_;
};

template <class Sums, class Visit>
void for_each_pixel(const TileArea& tile, std::array<Sums, tile_size * tile_size>& sums, const Visit& visit) {
  for (int row = tile.top; row < tile.bottom; ++row)
    for (int column = tile.left; column < tile.right; ++column)
      visit(column, row, sums[(row - tile.top) * tile_size + column - tile.left]);
}

// how many paths each pixel gets, where all are taken
struct SampleCounts {
  int usual, at_edges;
  std::vector<char> edges;  // of the picture's pixels that are kept, or empty
  int width;
  int of(int column, int row) const {
    return !edges.empty() && edges[std::size_t(row) * width + column] ? at_edges : usual;
  }
};

SampleCounts count_samples(const PathTraceOptions& options, const Crop& crop) {
  SampleCounts counts{options.samples, std::max(options.samples, options.edge_samples), {}, crop.x1 - crop.x0};
  if (options.noise > 0 || options.edges.empty()) return counts;
  assert(options.edges.size() == std::size_t(options.width) * options.height);
  for (int row = crop.y0; row < crop.y1; ++row) {
    const auto begin = options.edges.begin() + std::ptrdiff_t(row) * options.width;
    counts.edges.insert(counts.edges.end(), begin + crop.x0, begin + crop.x1);
  }
  return counts;
}

// all paths of a tile, pixel after pixel
void trace_tile(PathQueue& queue, const TileArea& tile, const SampleCounts& counts, TracedImage& image) {
  std::array<PixelSum, tile_size * tile_size> sums;
  for_each_pixel(tile, sums, [&](int column, int row, PixelSum& sum) {
    queue.add(column, row, 0, 0, counts.of(column, row), sum);
  });
  queue.flush();
  for_each_pixel(tile, sums, [&](int column, int row, const PixelSum& sum) { store_pixel(sum, image, column, row); });
}

// as many paths as the pixels need, in two halves
void trace_tile(PathQueue& queue, const TileArea& tile, const EnoughSamples& enough, TracedImage& image) {
  using Halves = std::array<PixelSum, 2>;
  std::array<Halves, tile_size * tile_size> sums;
  for_each_pixel(tile, sums, [&](int column, int row, Halves& halves) {
    for (int h = 0; h < 2; ++h) queue.add(column, row, h, 0, enough.first(), halves[h]);
  });
  queue.flush();
  for_each_pixel(tile, sums, [&](int column, int row, Halves& halves) {
    const std::array<int, 2> needed{enough.needed(halves[1]), enough.needed(halves[0])};
    for (int h = 0; h < 2; ++h) queue.add(column, row, h, enough.first(), needed[h], halves[h]);
  });
  queue.flush();
  for_each_pixel(tile, sums,
                 [&](int column, int row, const Halves& halves) { store_pixel(halves, image, column, row); });
}

void check(const PathTraceOptions& options, const Crop& crop) {
  const auto fail = [](const char* where, const char* what, int value) {
    throw Error(Fault::bad_data, {.where = where, .what = what, .value = std::to_string(value), .remedy = ""});
  };
  if (options.width < 1 || options.width > 65536) fail("render.size", "must lie between 1 and 65536", options.width);
  if (options.height < 1 || options.height > 65536) fail("render.size", "must lie between 1 and 65536", options.height);
  if (options.samples < 1 || options.samples > 65536)
    fail("render.samples", "must lie between 1 and 65536", options.samples);
  if (!(options.noise >= 0 && options.noise <= 1))
    throw Error(Fault::bad_data, {.where = "render.noise",
                                  .what = "must lie between 0 and 1",
                                  .value = std::to_string(options.noise),
                                  .remedy = ""});
  if (options.blocks < 1 || options.block < 0 || options.block >= options.blocks)
    fail("render.samples", "must be a block of the sequence", options.block);
  if (options.bounces < 0 || options.bounces > 1000)
    fail("render.bounces", "must lie between 0 and 1000", options.bounces);
  if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > options.width || crop.y1 > options.height || crop.x0 >= crop.x1 ||
      crop.y0 >= crop.y1)
    fail("render.crop", "must lie inside the picture and not be empty; left edge", crop.x0);
}

// black, with all the layers that the options and the scene ask for
TracedImage all_layers(const RenderScene& scene, const PathTraceOptions& options, int width, int height) {
  TracedImage image = black_image(width, height);
  if (lets_light_in(scene)) image.color_variance = Image(width, height);
  image.mattes.assign(options.mattes.size(), Image(width, height, 2 * matte_ranks));
  if (has_shadow_catchers(scene))
    image.caught = CaughtImage{.light = Image(width, height),
                               .half = Image(width, height),
                               .share = Image(width, height, 1),
                               .albedo = Image(width, height),
                               .normal = Image(width, height),
                               .depth = Image(width, height, 1)};
  return image;
}

// tells how much is done, one caller at a time
class Progress {
 public:
  Progress(const std::function<void(double)>& report, Eigen::Index total) : report_(report), total_(total) {}
  void add_one() {
    if (!report_) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    report_(double(++done_) / double(total_));
  }

 private:
  const std::function<void(double)>& report_;
  Eigen::Index total_, done_ = 0;
  std::mutex mutex_;
};

}  // namespace

TracedImage black_image(int width, int height) {
  return {.color = Image(width, height),
          .albedo = Image(width, height),
          .normal = Image(width, height),
          .depth = Image(width, height, 1),
          .variance = Image(width, height, 1),
          .half = Image(width, height),
          .samples = Image(width, height, 1),
          .alpha = Image(width, height, 1),
          .mattes = {}};
}

bool has_shadow_catchers(const RenderScene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [](const RenderObject& object) { return object.catches_shadows; });
}

TracedImage path_trace(const RayScene& rays, const RenderScene& scene, const PathTraceOptions& options) {
  const Crop crop = options.crop.value_or(Crop{.x0 = 0, .y0 = 0, .x1 = options.width, .y1 = options.height});
  check(options, crop);
  const PathTracer tracer = make_tracer(rays, scene, options);
  const int width = crop.x1 - crop.x0, height = crop.y1 - crop.y0;
  TracedImage image = all_layers(scene, options, width, height);
  const EnoughSamples enough(options.noise, options.samples, scene.exposure_stops);
  const SampleCounts counts = count_samples(options, crop);
  const Eigen::Index columns = (width + tile_size - 1) / tile_size,
                     tiles = columns * ((height + tile_size - 1) / tile_size);
  if (options.recording) options.recording->assign(tiles, {});
  Progress progress(options.on_progress, tiles);
  parallel_blocks(tiles, 1, [&](Eigen::Index tile, Eigen::Index) {
    if (options.stop && options.stop->load(std::memory_order_relaxed)) return;
    const FlushDenormals flush;
    const int left = int(tile % columns) * tile_size, top = int(tile / columns) * tile_size;
    const TileArea area{left, top, std::min(left + tile_size, width), std::min(top + tile_size, height)};
    TileParts parts(rays.objects(), options.mattes, left, top);
    CaughtLight caught(scene, left, top);
    PathQueue queue(tracer, crop, options.recording ? &(*options.recording)[tile] : nullptr, parts, caught);
    if (options.noise > 0)
      trace_tile(queue, area, enough, image);
    else
      trace_tile(queue, area, counts, image);
    parts.store(image);
    caught.store(image);
    progress.add_one();
  });
  return image;
}

TracedImage path_trace(const RenderScene& scene, const PathTraceOptions& options) {
  return path_trace(RayScene(scene), scene, options);
}

}  // namespace umax
