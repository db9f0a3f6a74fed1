#include "render/trace/path_trace.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/srgb.h"
#include "render/trace/path_wave.h"

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

PathTracer make_tracer(const RayScene& rays, const RenderScene& scene, const PathTraceOptions& options) {
  PathTracer tracer{.rays = rays,
                    .looks = {},
                    .lights = RectangleLights(scene.lights),
                    .sky = SkyLight(scene.sky),
                    .backdrop = scene.backdrop,
                    .camera = make_camera_view(scene.camera, options.width, options.height),
                    .sequence = SampleSequence(options.samples, options.seed),
                    .filter = {},
                    .bounces = options.bounces};
  for (const RenderObject& object : scene.objects)
    tracer.looks.push_back(make_bsdf_look(object.look, "object " + object.name));
  return tracer;
}

void store(Image& image, int x, int y, const Eigen::Vector3d& value) {
  float* pixel = image.pixel(x, y);
  for (int c = 0; c < 3; ++c) pixel[c] = float(value[c]);
}

// the paths of one pixel, summed in their order
struct PixelSum {
  Eigen::Vector3d color{0, 0, 0}, half{0, 0, 0}, albedo{0, 0, 0}, normal{0, 0, 0};
  double depth = 0, squares = 0, luminances = 0;
  int num_met = 0;

  void add(const PathResult& path, int sample) {
    const Eigen::Vector3d radiance = path.radiance.cast<double>();
    color += radiance;
    if (sample % 2 == 0) half += radiance;
    albedo += path.albedo.cast<double>();
    normal += path.normal.cast<double>();
    const double light = double(luminance(path.radiance.x(), path.radiance.y(), path.radiance.z()));
    luminances += light;
    squares += light * light;
    depth += double(path.depth);
    num_met += path.depth > 0;
  }

  void store_in(TracedImage& image, int column, int row, int samples) const {
    store(image.color, column, row, color / samples);
    store(image.half, column, row, half / ((samples + 1) / 2));
    store(image.albedo, column, row, albedo / samples);
    store(image.normal, column, row, normal / samples);
    *image.depth.pixel(column, row) = num_met ? float(depth / num_met) : 0.0f;
    const double mean = luminances / samples;
    *image.variance.pixel(column, row) =
        samples > 1 ? float(std::max(0.0, squares / samples - mean * mean) / (samples - 1)) : 0.0f;
  }
};

// part of the picture that one thread traces at a time: columns and rows of what is kept
struct TileArea {
  int left, top, right, bottom;
};

// all paths of a tile, pixel after pixel, in waves
void trace_tile(const PathTracer& tracer, const Crop& crop, const TileArea& tile, int samples, TracedImage& image,
                std::vector<RecordedRay>* recording) {
  PathWave wave(tracer);
  std::array<PixelSum, tile_size * tile_size> sums;
  std::vector<PathStart> starts;
  std::vector<int> pixels;
  const auto trace = [&] {
    const PathResult* results = wave.trace(starts, recording);
    for (std::size_t i = 0; i < starts.size(); ++i) sums[pixels[i]].add(results[i], starts[i].sample);
    starts.clear();
    pixels.clear();
  };
  for (int row = tile.top; row < tile.bottom; ++row) {
    for (int column = tile.left; column < tile.right; ++column) {
      for (int sample = 0; sample < samples; ++sample) {
        starts.push_back({.x = crop.x0 + column, .y = crop.y0 + row, .sample = sample});
        pixels.push_back((row - tile.top) * tile_size + column - tile.left);
        if (starts.size() == PathWave::max_paths) trace();
      }
    }
  }
  trace();
  for (int row = tile.top; row < tile.bottom; ++row)
    for (int column = tile.left; column < tile.right; ++column)
      sums[(row - tile.top) * tile_size + column - tile.left].store_in(image, column, row, samples);
}

void check(const PathTraceOptions& options, const Crop& crop) {
  const auto fail = [](const char* where, const char* what, int value) {
    throw Error(Fault::bad_data, {.where = where, .what = what, .value = std::to_string(value), .remedy = ""});
  };
  if (options.width < 1 || options.width > 65536) fail("render.size", "must lie between 1 and 65536", options.width);
  if (options.height < 1 || options.height > 65536) fail("render.size", "must lie between 1 and 65536", options.height);
  if (options.samples < 1 || options.samples > 65536)
    fail("render.samples", "must lie between 1 and 65536", options.samples);
  if (options.bounces < 0 || options.bounces > 1000)
    fail("render.bounces", "must lie between 0 and 1000", options.bounces);
  if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 > options.width || crop.y1 > options.height || crop.x0 >= crop.x1 ||
      crop.y0 >= crop.y1)
    fail("render.crop", "must lie inside the picture and not be empty; left edge", crop.x0);
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

TracedImage path_trace(const RayScene& rays, const RenderScene& scene, const PathTraceOptions& options) {
  const Crop crop = options.crop.value_or(Crop{.x0 = 0, .y0 = 0, .x1 = options.width, .y1 = options.height});
  check(options, crop);
  const PathTracer tracer = make_tracer(rays, scene, options);
  const int width = crop.x1 - crop.x0, height = crop.y1 - crop.y0;
  TracedImage image{.color = Image(width, height),
                    .albedo = Image(width, height),
                    .normal = Image(width, height),
                    .depth = Image(width, height, 1),
                    .variance = Image(width, height, 1),
                    .half = Image(width, height)};
  const Eigen::Index columns = (width + tile_size - 1) / tile_size,
                     tiles = columns * ((height + tile_size - 1) / tile_size);
  if (options.recording) options.recording->assign(tiles, {});
  Progress progress(options.on_progress, tiles);
  parallel_blocks(tiles, 1, [&](Eigen::Index tile, Eigen::Index) {
    if (options.stop && options.stop->load(std::memory_order_relaxed)) return;
    const FlushDenormals flush;
    const int left = int(tile % columns) * tile_size, top = int(tile / columns) * tile_size;
    const TileArea area{left, top, std::min(left + tile_size, width), std::min(top + tile_size, height)};
    trace_tile(tracer, crop, area, options.samples, image, options.recording ? &(*options.recording)[tile] : nullptr);
    progress.add_one();
  });
  return image;
}

TracedImage path_trace(const RenderScene& scene, const PathTraceOptions& options) {
  return path_trace(RayScene(scene), scene, options);
}

}  // namespace umax
