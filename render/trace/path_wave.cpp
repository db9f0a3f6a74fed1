// The steps of a wave: meet surfaces, add what shines there, look at lights, turn at random, and drop the paths that
// ended. Steps that call the ray library or branch a lot go path by path; the arithmetic between them runs over rows.
#include "render/trace/path_wave.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/trace/path_rows.h"

namespace umax {
namespace {

using namespace rows;
using bsdf_core::LobeChoice;

// pairs of dimensions of the sample points: a path's first ones, then a block for each vertex
enum Dimension { dim_filter, dim_lens, dims_of_camera };
constexpr int dim_time = SampleSequence::max_dimensions - 1;
enum VertexDimension { dim_light, dim_sky, dim_scatter, dim_roulette, dims_of_vertex };

// weight of one of two strategies that could have found the same light [Veach 1995, power heuristic]
inline float strategy_weight(float own_density, float other_density) {
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
  RowOf<int> slot;  // place of its result
  RayRows ray;
  ColorRows throughput;
  Row density;  // [1/sr] with which the ray's direction was chosen
  std::array<PathResult, capacity> results;

  // of the surface that it met
  HitRows hit;
  SurfacePoints surface_points;
  SurfacePointRows point;
  LightMetRows met;
  LightRows light;
  DirectionRows light_radiance;
  Row u, v;
  LookRows look;
  FrameRows frame;
  SurfaceRows surface;
  DirectionRows direction, cosine, mirrored;
  ColorRows value;
  Row value_density, choice_again, choice_alpha, weight;
  RowOf<int> goes_on;

  // rays towards lights
  RayRows shadow;
  RowOf<int> shadow_of, blocked;

  // --- camera
  void start(const std::vector<PathStart>& starts) {
    count = int(starts.size());
    std::uint32_t first_index = 0, pixel_key = 0;
    for (int i = 0; i < count; ++i) {
      const PathStart& s = starts[i];
      if (i == 0 || s.x != starts[i - 1].x || s.y != starts[i - 1].y) {
        first_index = tracer.sequence.pixel_start(s.x, s.y);
        pixel_key = tracer.sequence.block_key(s.x, s.y);
      }
      reversed_index[i] = reverse_bits(first_index + std::uint32_t(s.sample));
      block_key[i] = pixel_key ^ SampleSequence::stream_key(s.stream);
      slot[i] = i;
      throughput.set(i, {1, 1, 1});
      density[i] = 0;
      results[i] = PathResult{};
    }
    for (int i = 0; i < count; ++i) ray.time[i] = 0;
    if (tracer.has_shutter) draw(dim_time, ray.time, v);
    draw(dim_filter, u, v);
    for (int i = 0; i < count; ++i) {
      const Vector2f offset = tracer.filter.offset({u[i], v[i]});
      u[i] = float(starts[i].x) + 0.5f + offset.x();
      v[i] = float(starts[i].y) + 0.5f + offset.y();
    }
    const bool is_simple = tracer.cameras.size() == 1 && !(tracer.cameras.front().aperture_radius > 0);
    is_simple ? start_rays(tracer.cameras.front()) : start_moving_rays();
  }

  // from places in the picture, u and v [px], through a pinhole that stands still
  void start_rays(const CameraView& view) {
    const Direction position = direction_of(view.position), corner = direction_of(view.corner),
                    step_x = direction_of(view.step_x), step_y = direction_of(view.step_y);
    for (int i = 0; i < count; ++i) {
      const Direction towards = corner + u[i] * step_x + v[i] * step_y;
      ray.origin.set(i, position);
      ray.direction.set(i, towards / std::sqrt(dot(towards, towards)));
      ray.max_distance[i] = std::numeric_limits<float>::infinity();
    }
  }

  // through a lens, or a camera that moves
  void start_moving_rays() {
    Row lens_u, lens_v;
    for (int i = 0; i < count; ++i) lens_u[i] = lens_v[i] = 0;
    if (tracer.cameras.front().aperture_radius > 0) draw(dim_lens, lens_u, lens_v);
    for (int i = 0; i < count; ++i) {
      Ray start = camera_ray(camera_at(tracer.cameras, ray.time[i]), u[i], v[i], {lens_u[i], lens_v[i]});
      start.time = ray.time[i];
      ray.set(i, start);
    }
  }

  void draw(int dimension, Row& to_u, Row& to_v) const {
    tracer.sequence.points(reversed_index.data(), block_key.data(), count, dimension, to_u.data(), to_v.data());
  }

  // --- rays
  void meet_surfaces(bool from_camera) {
    if (recording) [[unlikely]]
      for (int i = 0; i < count; ++i) recording->push_back({ray.at(i), false});
    tracer.rays.intersect(ray, count, from_camera, hit);
  }

  // fills `blocked` for the first rays of `shadow`
  void find_blocked(int num_shadows, bool coherent) {
    if (recording) [[unlikely]]
      for (int k = 0; k < num_shadows; ++k) recording->push_back({shadow.at(k), true});
    tracer.rays.occluded(shadow, num_shadows, coherent, blocked);
  }

  // --- light that a ray itself meets
  // A rectangle in front of the surface, or the sky behind everything. False: nothing more to follow. Rectangles hide
  // what is behind them from the camera only: shadow rays pass through them, too.
  void add_emissions(bool from_camera) {
    const bool has_lights = !tracer.lights.empty();
    if (has_lights) {
      RayRows& free = shadow;  // as far as the next surface
      for (int i = 0; i < count; ++i) free.copy(i, i, ray);
      for (int i = 0; i < count; ++i) free.max_distance[i] = hit.found(i) ? hit.distance[i] : ray.max_distance[i];
      tracer.lights.meet(free, count, from_camera, met);
    }
    keep([&](int i) {
      const bool meets_light = has_lights && met.light[i] >= 0;
      if (meets_light) add_rectangle(i, from_camera);
      if (meets_light && from_camera) return false;
      if (hit.found(i)) return true;
      add_sky(i, from_camera);
      return false;
    });
  }

  void add_sky(int i, bool from_camera) {
    Vector3f& radiance = results[slot[i]].radiance;
    if (from_camera) {
      radiance += tracer.backdrop ? *tracer.backdrop : tracer.sky.radiance(ray.direction.vector(i));
    } else {
      radiance += throughput.vector(i).cwiseProduct(sky_seen(i));
    }
  }

  void add_rectangle(int i, bool from_camera) {
    float share = 1;
    const RectangleLights::Met here{.light = met.light[i], .distance = met.distance[i]};
    if (!from_camera)
      share = strategy_weight(density[i], tracer.lights.density(here, ray.origin.vector(i), ray.direction.vector(i)));
    results[slot[i]].radiance += share * throughput.vector(i).cwiseProduct(tracer.lights.radiance(here.light));
  }

  Vector3f sky_seen(int i) const {
    const Vector3f towards = ray.direction.vector(i), radiance = tracer.sky.radiance(towards);
    if (!tracer.sky.is_aimed()) return radiance;
    return strategy_weight(density[i], tracer.sky.density(towards)) * radiance;
  }

  // after the last bounce only light counts, so whether anything is in the way is enough to know
  void add_last_emission() {
    if (!tracer.lights.empty()) {
      tracer.lights.meet(ray, count, false, met);
      int num_shadows = 0;
      for (int i = 0; i < count; ++i) {
        if (met.light[i] < 0) continue;
        shadow.copy(num_shadows, i, ray);
        shadow.max_distance[num_shadows] = met.distance[i];
        shadow_of[num_shadows++] = i;
      }
      find_blocked(num_shadows, false);
      for (int k = 0; k < num_shadows; ++k)
        if (!blocked[k]) add_rectangle(shadow_of[k], false);
    }
    int num_shadows = 0;
    for (int i = 0; i < count; ++i) {
      const Vector3f sky = throughput.vector(i).cwiseProduct(sky_seen(i));
      if (!(sky.maxCoeff() > 0)) continue;
      light_radiance.set(num_shadows, sky);
      shadow.copy(num_shadows, i, ray);
      shadow_of[num_shadows++] = i;
    }
    find_blocked(num_shadows, false);
    for (int k = 0; k < num_shadows; ++k)
      if (!blocked[k]) results[slot[shadow_of[k]]].radiance += light_radiance.vector(k);
  }

  // --- surfaces
  void prepare_surfaces(bool first) {
    surface_points.find(tracer.rays.objects(), ray, hit, count, point);
    for (int i = 0; i < count; ++i) {
      const Direction n = point.normal.at(i);
      frame.z.set(i, n);
      const float sign = std::copysign(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
      frame.x.set(i, Direction{1 + sign * n.x * n.x * a, sign * b, -sign * n.x});
      frame.y.set(i, Direction{b, sign + n.y * n.y * a, -n.y});
    }
    for (int i = 0; i < count; ++i) {
      const Direction local = frame.to_local(i, -ray.direction.at(i));
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
                         point.base_color.at(i), surface.viewer.at(i)));
    }
    if (!first) return;
    for (int i = 0; i < count; ++i) {
      PathResult& result = results[slot[i]];
      result.albedo = surface.albedo.vector(i);
      result.normal = point.normal.vector(i);
      result.depth = hit.distance[i];
    }
  }

  void look_up() {
    for (int i = 0; i < count; ++i) {
      const BsdfLook& l = tracer.looks[hit.object[i]];
      const bsdf_core::LayerAlbedo layers = l.layers(surface.viewer.z[i]);
      look.alpha[i] = l.numbers.alpha, look.f0[i] = l.numbers.f0, look.f90[i] = l.numbers.f90;
      look.metallic[i] = l.numbers.metallic, look.coat[i] = l.numbers.coat, look.coat_alpha[i] = l.numbers.coat_alpha;
      look.a[i] = layers.a, look.b[i] = layers.b, look.coat_a[i] = layers.coat_a, look.coat_b[i] = layers.coat_b;
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
  void add_lights(int vertex_dimension, bool first) {
    if (!tracer.lights.empty()) {
      draw(vertex_dimension + dim_light, u, v);
      tracer.lights.sample(point.departure, u, v, count, light);
      for (int i = 0; i < count; ++i) light_radiance.set(i, tracer.lights.radiance(light.light[i]));
      add_light_samples(first);
    }
    if (tracer.sky.is_aimed()) {
      draw(vertex_dimension + dim_sky, u, v);
      for (int i = 0; i < count; ++i) {
        const LightSample sample = tracer.sky.sample({u[i], v[i]});
        light.direction.set(i, sample.direction);
        light.distance[i] = sample.distance, light.density[i] = sample.density;
        light_radiance.set(i, sample.radiance);
      }
      add_light_samples(first);
    }
  }

  void add_light_samples(bool first) {
    for (int i = 0; i < count; ++i) direction.set(i, frame.to_local(i, light.direction.at(i)));
    evaluate_directions();
    for (int i = 0; i < count; ++i) {
      const bool above = dot(light.direction.at(i), point.geometric_normal.at(i)) > 0;
      const bool is_seen = (value.r[i] > 0) | (value.g[i] > 0) | (value.b[i] > 0);
      goes_on[i] = (light.density[i] > 0) & above & is_seen ? 1 : 0;
      weight[i] = strategy_weight(light.density[i], value_density[i]) / light.density[i];
    }
    int num_shadows = 0;
    for (int i = 0; i < count; ++i) {
      if (!goes_on[i]) continue;
      shadow.origin.set(num_shadows, point.departure.at(i));
      shadow.direction.set(num_shadows, light.direction.at(i));
      shadow.max_distance[num_shadows] = light.distance[i] - 4 * point.offset[i];
      shadow.time[num_shadows] = ray.time[i];
      shadow_of[num_shadows++] = i;
    }
    find_blocked(num_shadows, first);
    for (int k = 0; k < num_shadows; ++k) {
      if (blocked[k]) continue;
      const int i = shadow_of[k];
      results[slot[i]].radiance +=
          weight[i] * throughput.vector(i).cwiseProduct(value.vector(i)).cwiseProduct(light_radiance.vector(i));
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
    turn(first);
    keep([&](int i) { return goes_on[i] != 0; });
  }

  void turn(bool first) {
    for (int i = 0; i < count; ++i) {
      const bool outwards = dot(direction.at(i), point.geometric_normal.at(i)) > 0;
      const float r = throughput.r[i] * value.r[i] / value_density[i],
                  g = throughput.g[i] * value.g[i] / value_density[i],
                  b = throughput.b[i] * value.b[i] / value_density[i];
      const float most = bsdf_core::larger(bsdf_core::larger(r, g), b);
      const bool by_chance = !first & (most < 1);
      const float chance = by_chance ? std::sqrt(most) : 1.0f;
      goes_on[i] = (value_density[i] > 0) & outwards & (most > 0) & !(by_chance & (u[i] >= chance)) ? 1 : 0;
      throughput.set(i, {r / chance, g / chance, b / chance});
      ray.origin.set(i, point.departure.at(i));
      ray.direction.set(i, direction.at(i));
      ray.max_distance[i] = std::numeric_limits<float>::infinity();
      density[i] = value_density[i];
    }
  }

  // --- which paths go on
  template <class GoesOn>
  void keep(const GoesOn& goes) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      if (!goes(i)) continue;
      if (kept != i) {
        reversed_index[kept] = reversed_index[i];
        block_key[kept] = block_key[i];
        slot[kept] = slot[i];
        ray.copy(kept, i, ray);
        throughput.set(kept, throughput.at(i));
        density[kept] = density[i];
        hit.copy(kept, i);
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
    wave.add_emissions(first);
    wave.prepare_surfaces(first);
    const int vertex_dimension = dims_of_camera + bounce * dims_of_vertex;
    wave.add_lights(vertex_dimension, first);
    wave.scatter(vertex_dimension, first);
  }
  wave.add_last_emission();
  return wave.results.data();
}

}  // namespace umax
