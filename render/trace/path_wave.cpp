// The steps of a wave: meet surfaces, add what shines there, look at lights, turn at random, and drop the paths that
// ended. Steps that call the ray library or branch a lot go path by path; the arithmetic between them runs over rows.
#include "render/trace/path_wave.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/trace/path_rows.h"

namespace umax {
namespace {

using namespace path_rows;
using bsdf_core::LobeChoice;

// pairs of dimensions of the sample points: a path's first ones, then a block for each vertex
enum Dimension { dim_filter, dim_lens, dims_of_camera };
enum VertexDimension { dim_light, dim_sky, dim_scatter, dim_roulette, dims_of_vertex };

// weight of one of two strategies that could have found the same light [Veach 1995, power heuristic]
float strategy_weight(float own_density, float other_density) {
  const float own = own_density * own_density, other = other_density * other_density;
  return own / (own + other);
}

}  // namespace

struct PathWave::Buffers {
  explicit Buffers(const PathTracer& tracer_) : tracer(tracer_) {}

  const PathTracer& tracer;
  std::vector<RecordedRay>* recording = nullptr;
  int count = 0;  // paths still on their way; theirs are the first entries of everything below

  // of a path
  RowOf<std::uint32_t> reversed_index, block_key;
  std::array<int, max_paths> slot{};  // place of its result
  std::array<Ray, max_paths> ray;
  std::array<Vector3f, max_paths> throughput;
  Row density;  // [1/sr] with which the ray's direction was chosen
  std::array<PathResult, max_paths> results;

  // of the surface that it met
  std::array<Hit, max_paths> hit;
  std::array<SurfacePoint, max_paths> point;
  std::array<LightSample, max_paths> light;
  Row u, v;
  LookRows look;
  FrameRows frame;
  SurfaceRows surface;
  DirectionRows direction, cosine, mirrored;
  ColorRows value;
  Row value_density, choice_again, choice_alpha;

  // --- camera
  void start(const std::vector<PathStart>& starts) {
    count = int(starts.size());
    for (int i = 0; i < count; ++i) {
      const PathStart& s = starts[i];
      reversed_index[i] = reverse_bits(tracer.sequence.pixel_start(s.x, s.y) + std::uint32_t(s.sample));
      block_key[i] = tracer.sequence.block_key(s.x, s.y);
      slot[i] = i;
      throughput[i] = Vector3f(1, 1, 1);
      density[i] = 0;
      results[i] = PathResult{};
    }
    Row lens_u{}, lens_v{};
    if (tracer.camera.aperture_radius > 0) draw(dim_lens, lens_u, lens_v);
    draw(dim_filter, u, v);
    for (int i = 0; i < count; ++i) {
      const Vector2f offset = tracer.filter.offset({u[i], v[i]});
      ray[i] = camera_ray(tracer.camera, float(starts[i].x) + 0.5f + offset.x(), float(starts[i].y) + 0.5f + offset.y(),
                          {lens_u[i], lens_v[i]});
    }
  }

  void draw(int dimension, Row& to_u, Row& to_v) const {
    tracer.sequence.points(reversed_index.data(), block_key.data(), count, dimension, to_u.data(), to_v.data());
  }

  // --- rays
  void meet_surfaces(bool from_camera) {
    if (recording) [[unlikely]]
      for (int i = 0; i < count; ++i) recording->push_back({ray[i], false});
    if (from_camera) {
      tracer.rays.intersect_coherent(ray.data(), count, hit.data());
    } else {
      for (int i = 0; i < count; ++i) hit[i] = tracer.rays.intersect(ray[i]);
    }
  }

  bool blocked(const Ray& shadow) const {
    if (recording) [[unlikely]]
      recording->push_back({shadow, true});
    return tracer.rays.occluded(shadow);
  }

  // --- light that a ray itself meets
  // A rectangle in front of the surface, or the sky behind everything. False: nothing more to follow. Rectangles hide
  // what is behind them from the camera only: shadow rays pass through them, too.
  bool add_emission(int i, bool from_camera) {
    if (!tracer.lights.empty()) {
      const float free_path = hit[i].found() ? hit[i].distance : ray[i].max_distance;
      const auto met = tracer.lights.meet(ray[i].origin, ray[i].direction, free_path, from_camera);
      if (met.light >= 0) add_rectangle(i, met, from_camera);
      if (met.light >= 0 && from_camera) return false;
    }
    if (hit[i].found()) return true;
    Vector3f& radiance = results[slot[i]].radiance;
    if (from_camera) {
      radiance += tracer.backdrop ? *tracer.backdrop : tracer.sky.radiance(ray[i].direction);
    } else {
      radiance += throughput[i].cwiseProduct(sky_seen(i));
    }
    return false;
  }

  void add_rectangle(int i, const RectangleLights::Met& met, bool from_camera) {
    float weight = 1;
    if (!from_camera) {
      weight = strategy_weight(density[i], tracer.lights.density(met, ray[i].origin, ray[i].direction));
    }
    results[slot[i]].radiance += weight * throughput[i].cwiseProduct(tracer.lights.radiance(met.light));
  }

  Vector3f sky_seen(int i) const {
    Vector3f radiance = tracer.sky.radiance(ray[i].direction);
    if (!tracer.sky.is_aimed()) return radiance;
    return strategy_weight(density[i], tracer.sky.density(ray[i].direction)) * radiance;
  }

  // after the last bounce only light counts, so whether anything is in the way is enough to know
  void add_last_emission() {
    for (int i = 0; i < count; ++i) {
      const auto met = tracer.lights.meet(ray[i].origin, ray[i].direction, ray[i].max_distance, false);
      if (met.light >= 0) {
        Ray shadow = ray[i];
        shadow.max_distance = met.distance;
        if (!blocked(shadow)) add_rectangle(i, met, false);
      }
      const Vector3f sky = throughput[i].cwiseProduct(sky_seen(i));
      if (sky.maxCoeff() > 0 && !blocked(ray[i])) results[slot[i]].radiance += sky;
    }
  }

  // --- surfaces
  void prepare_surfaces(bool first) {
    for (int i = 0; i < count; ++i) {
      point[i] = tracer.rays.surface(hit[i], ray[i].direction);
      frame.z.set(i, point[i].normal);
      direction.set(i, Vector3f(-ray[i].direction));
    }
    for (int i = 0; i < count; ++i) {
      const Direction n = frame.z.at(i);
      const float sign = std::copysign(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
      frame.x.set(i, Direction{1 + sign * n.x * n.x * a, sign * b, -sign * n.x});
      frame.y.set(i, Direction{b, sign + n.y * n.y * a, -n.y});
    }
    for (int i = 0; i < count; ++i) {
      const Direction local = frame.to_local(i, direction.at(i));
      surface.viewer.set(i, Direction{local.x, local.y, bsdf_core::larger(local.z, 1e-4f)});
    }
    look_up();
    for (int i = 0; i < count; ++i) {
      surface.set(i, bsdf_core::make_surface(
                         {.alpha = look.alpha[i],
                          .f0 = look.f0[i],
                          .f90 = look.f90[i],
                          .metallic = look.metallic[i],
                          .coat = look.coat[i],
                          .coat_alpha = look.coat_alpha[i]},
                         {.a = look.a[i], .b = look.b[i], .coat_a = look.coat_a[i], .coat_b = look.coat_b[i]},
                         look.base.at(i), surface.viewer.at(i)));
    }
    if (!first) return;
    for (int i = 0; i < count; ++i) {
      PathResult& result = results[slot[i]];
      result.albedo = surface.albedo.vector(i);
      result.normal = point[i].normal;
      result.depth = hit[i].distance;
    }
  }

  void look_up() {
    for (int i = 0; i < count; ++i) {
      const BsdfLook& l = tracer.looks[hit[i].object];
      const bsdf_core::LayerAlbedo layers = l.layers(surface.viewer.z[i]);
      look.alpha[i] = l.numbers.alpha, look.f0[i] = l.numbers.f0, look.f90[i] = l.numbers.f90;
      look.metallic[i] = l.numbers.metallic, look.coat[i] = l.numbers.coat, look.coat_alpha[i] = l.numbers.coat_alpha;
      look.a[i] = layers.a, look.b[i] = layers.b, look.coat_a[i] = layers.coat_a, look.coat_b[i] = layers.coat_b;
      const Vector3f& base = point[i].base_color;
      look.base.set(i, {base.x(), base.y(), base.z()});
    }
  }

  void evaluate_directions() {
    for (int i = 0; i < count; ++i) {
      const bsdf_core::Value result = bsdf_core::evaluate(surface.at(i), direction.at(i));
      value.set(i, result.value);
      value_density[i] = result.density;
    }
  }

  // --- lights that are looked for
  void add_lights(int vertex_dimension) {
    if (!tracer.lights.empty()) {
      draw(vertex_dimension + dim_light, u, v);
      for (int i = 0; i < count; ++i)
        light[i] = tracer.lights.sample(leave_surface(point[i], point[i].geometric_normal), {u[i], v[i]});
      add_light_samples();
    }
    if (tracer.sky.is_aimed()) {
      draw(vertex_dimension + dim_sky, u, v);
      for (int i = 0; i < count; ++i) light[i] = tracer.sky.sample({u[i], v[i]});
      add_light_samples();
    }
  }

  void add_light_samples() {
    for (int i = 0; i < count; ++i) direction.set(i, light[i].direction);
    for (int i = 0; i < count; ++i) direction.set(i, frame.to_local(i, direction.at(i)));
    evaluate_directions();
    for (int i = 0; i < count; ++i) {
      const LightSample& sample = light[i];
      const Vector3f f = value.vector(i);
      if (!(sample.density > 0) || !(sample.direction.dot(point[i].geometric_normal) > 0) || !(f.maxCoeff() > 0))
        continue;
      Ray shadow{.origin = leave_surface(point[i], sample.direction), .direction = sample.direction};
      shadow.max_distance = sample.distance - 4 * point[i].offset;
      if (blocked(shadow)) continue;
      const float weight = strategy_weight(sample.density, value_density[i]) / sample.density;
      results[slot[i]].radiance += weight * throughput[i].cwiseProduct(f).cwiseProduct(sample.radiance);
    }
  }

  // --- the next direction
  void scatter(int vertex_dimension, bool first) {
    draw(vertex_dimension + dim_scatter, u, v);
    for (int i = 0; i < count; ++i) {
      const LobeChoice choice = bsdf_core::choose_lobe(surface.at(i), u[i]);
      choice_again[i] = choice.again;
      choice_alpha[i] = choice.alpha;
    }
    for (int i = 0; i < count; ++i) cosine.set(i, bsdf_core::cosine_direction(choice_again[i], v[i]));
    for (int i = 0; i < count; ++i) {
      mirrored.set(i, bsdf_core::mirrored_direction(choice_alpha[i], surface.viewer.at(i), choice_again[i], v[i]));
    }
    for (int i = 0; i < count; ++i) {
      const LobeChoice choice{.again = choice_again[i], .alpha = choice_alpha[i]};
      direction.set(i, bsdf_core::select_direction(choice, cosine.at(i), mirrored.at(i)));
    }
    evaluate_directions();
    for (int i = 0; i < count; ++i) direction.set(i, frame.to_world(i, direction.at(i)));
    // paths that carry little are ended by chance, those that go on carry their share
    if (!first) draw(vertex_dimension + dim_roulette, u, v);
    keep([&](int i) { return turn(i, first); });
  }

  bool turn(int i, bool first) {
    const Vector3f towards = direction.vector(i);
    if (!(value_density[i] > 0) || !(towards.dot(point[i].geometric_normal) > 0)) return false;
    Vector3f next = throughput[i].cwiseProduct(value.vector(i)) / value_density[i];
    const float most = next.maxCoeff();
    if (!(most > 0)) return false;
    if (!first && most < 1) {
      const float chance = std::sqrt(most);
      if (u[i] >= chance) return false;
      next /= chance;
    }
    throughput[i] = next;
    ray[i] = {.origin = leave_surface(point[i], towards), .direction = towards};
    density[i] = value_density[i];
    return true;
  }

  // --- which paths go on
  template <class GoesOn>
  void keep(const GoesOn& goes_on) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      if (!goes_on(i)) continue;
      if (kept != i) {
        reversed_index[kept] = reversed_index[i];
        block_key[kept] = block_key[i];
        slot[kept] = slot[i];
        ray[kept] = ray[i];
        throughput[kept] = throughput[i];
        density[kept] = density[i];
        hit[kept] = hit[i];
      }
      ++kept;
    }
    count = kept;
  }
};

PathWave::PathWave(const PathTracer& tracer) : buffers_(std::make_unique<Buffers>(tracer)) {}
PathWave::~PathWave() = default;

const PathResult* PathWave::trace(const std::vector<PathStart>& starts, std::vector<RecordedRay>* recording) {
  Buffers& wave = *buffers_;
  wave.recording = recording;
  wave.start(starts);
  for (int bounce = 0; bounce <= wave.tracer.bounces && wave.count > 0; ++bounce) {
    const bool first = bounce == 0;
    wave.meet_surfaces(first);
    wave.keep([&](int i) { return wave.add_emission(i, first); });
    wave.prepare_surfaces(first);
    const int vertex_dimension = dims_of_camera + bounce * dims_of_vertex;
    wave.add_lights(vertex_dimension);
    wave.scatter(vertex_dimension, first);
  }
  wave.add_last_emission();
  return wave.results.data();
}

}  // namespace umax
