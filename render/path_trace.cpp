#include "render/path_trace.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>

#include "core/error.h"
#include "core/parallel.h"
#include "render/bsdf.h"
#include "render/camera.h"
#include "render/light.h"
#include "render/sampling.h"
#include "render/srgb.h"

namespace umax {
namespace {

constexpr int tile_size = 16;  // [px]

// Denormals cost Embree time. The setting is this thread's own and put back, so that no other computation meets it.
class FlushDenormals {
 public:
#if defined(__SSE2__)
  FlushDenormals() : saved_(_mm_getcsr()) {
    _mm_setcsr(saved_ | 0x8040u);
  }
  ~FlushDenormals() {
    _mm_setcsr(saved_);
  }

 private:
  unsigned saved_;
#else
  FlushDenormals() = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;
};

// everything that stays the same for a whole picture
struct Tracer {
  const RayScene& rays;
  std::vector<BsdfLook> looks;
  RectangleLights lights;
  SkyLight sky;
  std::optional<Vector3f> backdrop;
  CameraView camera;
  SampleSequence sequence;
  PixelFilter filter;
  int bounces;

  Tracer(const RayScene& rays_, const RenderScene& scene, const PathTraceOptions& options)
      : rays(rays_),
        lights(scene.lights),
        sky(scene.sky),
        backdrop(scene.backdrop),
        camera(make_camera_view(scene.camera, options.width, options.height)),
        sequence(options.samples, options.seed),
        bounces(options.bounces) {
    looks.reserve(scene.objects.size());
    for (const RenderObject& object : scene.objects)
      looks.push_back(make_bsdf_look(object.look, "object " + object.name));
  }
};

// dimensions of the sample points, in pairs: a path's first ones, then a block for each vertex
enum Dimension { dim_filter, dim_lens, dims_of_camera };
enum VertexDimension { dim_light, dim_sky, dim_scatter, dim_roulette, dims_of_vertex };

struct PathResult {
  Vector3f radiance{0, 0, 0}, albedo{1, 1, 1}, normal{0, 0, 0};
  float depth = 0;
};

// weight of one of two strategies that could have found the same light [Veach 1995, power heuristic]
float strategy_weight(float own_density, float other_density) {
  const float own = own_density * own_density, other = other_density * other_density;
  return own / (own + other);
}

// one path from the camera, vertex by vertex
class Path {
 public:
  Path(const Tracer& tracer, PathSampler& sampler, std::vector<RecordedRay>* recording)
      : tracer_(tracer), sampler_(sampler), recording_(recording) {}

  PathResult trace(int x, int y) {
    const Vector2f offset = tracer_.filter.offset(sampler_.next());
    const Vector2f lens = tracer_.camera.aperture_radius > 0 ? sampler_.next() : Vector2f(0, 0);
    ray_ = camera_ray(tracer_.camera, float(x) + 0.5f + offset.x(), float(y) + 0.5f + offset.y(), lens);
    for (int bounce = 0; bounce <= tracer_.bounces; ++bounce) {
      const Hit hit = intersect();
      const bool ended = add_emission(bounce == 0, hit);
      if (ended || !scatter(hit, bounce)) return result_;
    }
    add_last_emission();
    return result_;
  }

 private:
  Hit intersect() {
    if (recording_) [[unlikely]]
      recording_->push_back({ray_, false});
    return tracer_.rays.intersect(ray_);
  }

  bool blocked(const Ray& ray) {
    if (recording_) [[unlikely]]
      recording_->push_back({ray, true});
    return tracer_.rays.occluded(ray);
  }

  // Light that the ray itself meets: a rectangle in front of the surface, or the sky behind everything. True: nothing
  // more to follow. Rectangles hide what is behind them from the camera only: shadow rays pass through them, too.
  bool add_emission(bool from_camera, const Hit& hit) {
    if (!tracer_.lights.empty()) {
      const float free_path = hit.found() ? hit.distance : ray_.max_distance;
      const auto met = tracer_.lights.meet(ray_.origin, ray_.direction, free_path, from_camera);
      if (met.light >= 0) add_rectangle(met, from_camera);
      if (met.light >= 0 && from_camera) return true;
    }
    if (hit.found()) return false;
    if (from_camera) {
      result_.radiance += tracer_.backdrop ? *tracer_.backdrop : tracer_.sky.radiance(ray_.direction);
    } else {
      result_.radiance += throughput_.cwiseProduct(sky_seen());
    }
    return true;
  }

  void add_rectangle(const RectangleLights::Met& met, bool from_camera) {
    float weight = 1;
    if (!from_camera) weight = strategy_weight(density_, tracer_.lights.density(met, ray_.origin, ray_.direction));
    result_.radiance += weight * throughput_.cwiseProduct(tracer_.lights.radiance(met.light));
  }

  Vector3f sky_seen() const {
    const Vector3f radiance = tracer_.sky.radiance(ray_.direction);
    if (!tracer_.sky.is_aimed()) return radiance;
    return strategy_weight(density_, tracer_.sky.density(ray_.direction)) * radiance;
  }

  // after the last bounce only light counts, so whether anything is in the way is enough to know
  void add_last_emission() {
    const auto met = tracer_.lights.meet(ray_.origin, ray_.direction, ray_.max_distance, false);
    const Vector3f sky = throughput_.cwiseProduct(sky_seen());
    if (met.light < 0 && !(sky.maxCoeff() > 0)) return;
    Ray ray = ray_;
    if (met.light >= 0) {
      ray.max_distance = met.distance;
      if (!blocked(ray)) add_rectangle(met, false);
      ray.max_distance = std::numeric_limits<float>::infinity();
    }
    if (sky.maxCoeff() > 0 && !blocked(ray)) result_.radiance += sky;
  }

  // gathers light at a surface and turns the ray; false: the path ends here
  bool scatter(const Hit& hit, int bounce) {
    const SurfacePoint point = tracer_.rays.surface(hit, ray_.direction);
    const Frame frame(point.normal);
    Vector3f to_viewer = frame.to_local(-ray_.direction);
    to_viewer.z() = std::max(to_viewer.z(), 1e-4f);
    const Bsdf bsdf = make_bsdf(tracer_.looks[hit.object], point.base_color, to_viewer);
    if (bounce == 0) {
      result_.albedo = bsdf.albedo;
      result_.normal = point.normal;
      result_.depth = hit.distance;
    }
    const int dimension = dims_of_camera + bounce * dims_of_vertex;
    if (!tracer_.lights.empty()) {
      sampler_.seek(dimension + dim_light);
      add_light(tracer_.lights.sample(leave_surface(point, point.geometric_normal), sampler_.next()), point, frame,
                bsdf);
    }
    if (tracer_.sky.is_aimed()) {
      sampler_.seek(dimension + dim_sky);
      add_light(tracer_.sky.sample(sampler_.next()), point, frame, bsdf);
    }
    sampler_.seek(dimension + dim_scatter);
    const BsdfSample sample = sample_bsdf(bsdf, sampler_.next());
    if (!(sample.weight.maxCoeff() > 0)) return false;
    const Vector3f direction = frame.to_world(sample.to_light);
    if (!(direction.dot(point.geometric_normal) > 0)) return false;
    throughput_ = throughput_.cwiseProduct(sample.weight);
    if (bounce > 0 && !survives_roulette(dimension)) return false;
    ray_ = {.origin = leave_surface(point, direction), .direction = direction};
    density_ = sample.density;
    return true;
  }

  // paths that carry little are ended by chance, those that go on carry their share
  bool survives_roulette(int dimension) {
    const float chance = std::sqrt(throughput_.maxCoeff());
    if (chance >= 1) return true;
    sampler_.seek(dimension + dim_roulette);
    if (sampler_.next().x() >= chance) return false;
    throughput_ /= chance;
    return true;
  }

  void add_light(const LightSample& light, const SurfacePoint& point, const Frame& frame, const Bsdf& bsdf) {
    if (!(light.density > 0) || !(light.direction.dot(point.geometric_normal) > 0)) return;
    const BsdfValue value = evaluate_bsdf(bsdf, frame.to_local(light.direction));
    if (!(value.value.maxCoeff() > 0)) return;
    Ray ray{.origin = leave_surface(point, light.direction), .direction = light.direction};
    ray.max_distance = light.distance - 4 * point.offset;
    if (blocked(ray)) return;
    const float weight = strategy_weight(light.density, value.density) / light.density;
    result_.radiance += weight * throughput_.cwiseProduct(value.value).cwiseProduct(light.radiance);
  }

  const Tracer& tracer_;
  PathSampler& sampler_;
  std::vector<RecordedRay>* recording_;
  Ray ray_;
  Vector3f throughput_{1, 1, 1};
  float density_ = 0;  // [1/sr] with which the ray's direction was chosen
  PathResult result_;
};

void store(Image& image, int x, int y, const Eigen::Vector3d& value) {
  float* pixel = image.pixel(x, y);
  for (int c = 0; c < 3; ++c) pixel[c] = float(value[c]);
}

// all paths of one pixel; (x, y) in the whole picture, (column, row) in the part that is kept
void trace_pixel(const Tracer& tracer, int samples, int x, int y, int column, int row, TracedImage& image,
                 std::vector<RecordedRay>* recording) {
  Eigen::Vector3d color(0, 0, 0), half(0, 0, 0), albedo(0, 0, 0), normal(0, 0, 0);
  double depth = 0, squares = 0, luminances = 0;
  int num_met = 0;
  PathSampler sampler(tracer.sequence, x, y);
  for (int s = 0; s < samples; ++s) {
    sampler.begin_path(s);
    const PathResult path = Path(tracer, sampler, recording).trace(x, y);
    color += path.radiance.cast<double>();
    if (s % 2 == 0) half += path.radiance.cast<double>();
    albedo += path.albedo.cast<double>();
    normal += path.normal.cast<double>();
    const double light = double(luminance(path.radiance.x(), path.radiance.y(), path.radiance.z()));
    luminances += light;
    squares += light * light;
    depth += double(path.depth);
    num_met += path.depth > 0;
  }
  store(image.color, column, row, color / samples);
  store(image.half, column, row, half / ((samples + 1) / 2));
  store(image.albedo, column, row, albedo / samples);
  store(image.normal, column, row, normal / samples);
  *image.depth.pixel(column, row) = num_met ? float(depth / num_met) : 0.0f;
  const double mean = luminances / samples;
  *image.variance.pixel(column, row) =
      samples > 1 ? float(std::max(0.0, squares / samples - mean * mean) / (samples - 1)) : 0.0f;
}

void check(const PathTraceOptions& options, const Crop& crop) {
  const auto fail = [](const char* where, const char* what, int value) {
    throw Error(ExitCode::bad_data, {.where = where, .what = what, .value = std::to_string(value), .remedy = ""});
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
  const Tracer tracer(rays, scene, options);
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
    std::vector<RecordedRay>* recording = options.recording ? &(*options.recording)[tile] : nullptr;
    for (int row = top; row < std::min(top + tile_size, height); ++row)
      for (int column = left; column < std::min(left + tile_size, width); ++column)
        trace_pixel(tracer, options.samples, crop.x0 + column, crop.y0 + row, column, row, image, recording);
    progress.add_one();
  });
  return image;
}

TracedImage path_trace(const RenderScene& scene, const PathTraceOptions& options) {
  return path_trace(RayScene(scene), scene, options);
}

}  // namespace umax
