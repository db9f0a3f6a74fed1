// The steps of a wave: meet surfaces, add what shines there, look at lights, turn at random, and drop the paths that
// ended. Steps that call the ray library or branch a lot go path by path; the arithmetic between them runs over rows.
#include "render/trace/path_wave.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/trace/path_wave_buffers.h"

namespace umax {

using namespace rows;
using bsdf_core::LobeChoice;

// --- camera
void PathWave::Buffers::start(const std::vector<PathStart>& starts) {
  count = int(starts.size());
  std::uint32_t first_index = 0, pixel_key = 0;
  for (int i = 0; i < count; ++i) {
    const PathStart& s = starts[i];
    if (i == 0 || s.x != starts[i - 1].x || s.y != starts[i - 1].y) {
      first_index = tracer.sequence.pixel_start(s.x, s.y);
      pixel_key = tracer.sequence.block_key(s.x, s.y);
    }
    reversed_index[i] = reverse_bits(first_index + std::uint32_t(tracer.first_sample + s.sample));
    block_key[i] = pixel_key ^ SampleSequence::stream_key(s.stream);
    slot[i] = i;
    throughput.set(i, {1, 1, 1});
    density[i] = 0;
    sight[i] = Sight::none;
    results[i] = PathResult{};
  }
  if (tracer.keeps_parts) first_parts.fill({});
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
void PathWave::Buffers::start_rays(const CameraView& view) {
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
void PathWave::Buffers::start_moving_rays() {
  Row lens_u, lens_v;
  for (int i = 0; i < count; ++i) lens_u[i] = lens_v[i] = 0;
  if (tracer.cameras.front().aperture_radius > 0) draw(dim_lens, lens_u, lens_v);
  for (int i = 0; i < count; ++i) {
    Ray start = camera_ray(camera_at(tracer.cameras, ray.time[i]), u[i], v[i], {lens_u[i], lens_v[i]});
    start.time = ray.time[i];
    ray.set(i, start);
  }
}

void PathWave::Buffers::draw(int dimension, Row& to_u, Row& to_v) const {
  tracer.sequence.points(reversed_index.data(), block_key.data(), count, dimension, to_u.data(), to_v.data());
}

// --- rays
void PathWave::Buffers::meet_surfaces(bool from_camera) {
  if (recording) [[unlikely]]
    for (int i = 0; i < count; ++i) recording->push_back({ray.at(i), false});
  tracer.rays.intersect(ray, count, from_camera, hit);
}

// fills `blocked` for the first rays of `shadow`
void PathWave::Buffers::find_blocked(int num_shadows, bool coherent) {
  if (recording) [[unlikely]]
    for (int k = 0; k < num_shadows; ++k) recording->push_back({shadow.at(k), true});
  tracer.rays.occluded(shadow, num_shadows, coherent, blocked);
}

// --- surfaces
void PathWave::Buffers::prepare_surfaces(bool first) {
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
    surface.set(
        i, bsdf_core::make_surface({.alpha = look.alpha[i],
                                    .f0 = look.f0[i],
                                    .f90 = look.f90[i],
                                    .metallic = look.metallic[i],
                                    .coat = look.coat[i],
                                    .coat_alpha = look.coat_alpha[i]},
                                   {.a = look.a[i], .b = look.b[i], .coat_a = look.coat_a[i], .coat_b = look.coat_b[i]},
                                   point.base_color.at(i), surface.viewer.at(i)));
  }
  if (!first) return tracer.has_matter ? guide_through() : void();
  for (int i = 0; i < count; ++i) {
    PathResult& result = results[slot[i]];
    result.albedo = surface.albedo.vector(i);
    if (throughput.r[i] < 1) result.albedo += (1 - throughput.r[i]) * (Vector3f(1, 1, 1) - result.albedo);  // faded
    result.normal = point.normal.vector(i);
    result.depth = hit.distance[i];
  }
  for (int i = 0; i < count && tracer.keeps_parts; ++i) first_parts[slot[i]] = {hit.object[i], hit.triangle[i]};
}

void PathWave::Buffers::look_up() {
  for (int i = 0; i < count; ++i) {
    const BsdfLook& l = tracer.looks[hit.object[i]];
    const bsdf_core::LayerAlbedo layers = l.layers(surface.viewer.z[i]);
    look.alpha[i] = l.numbers.alpha, look.f0[i] = l.numbers.f0, look.f90[i] = l.numbers.f90;
    look.metallic[i] = l.numbers.metallic, look.coat[i] = l.numbers.coat, look.coat_alpha[i] = l.numbers.coat_alpha;
    look.a[i] = layers.a, look.b[i] = layers.b, look.coat_a[i] = layers.coat_a, look.coat_b[i] = layers.coat_b;
  }
}

void PathWave::Buffers::evaluate_directions() {
  for (int i = 0; i < count; ++i) {
    const bsdf_core::Value result = bsdf_core::evaluate(surface.at(i), direction.at(i));
    value.set(i, result.value);
    value_density[i] = result.density;
  }
}

// --- the next direction
void PathWave::Buffers::scatter(int vertex_dimension, bool first) {
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
  if (tracer.has_matter) go_through();
  keep([&](int i) { return goes_on[i] != 0; });
}

void PathWave::Buffers::turn(bool first) {
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
    if (first && !wave.tracer.fades.empty()) wave.fade_out();
    if (!first && wave.tracer.has_matter) wave.fade_through();
    wave.prepare_surfaces(first);
    if (wave.tracer.has_matter) wave.enter_matter(bounce);
    const int vertex_dimension = dims_of_camera + bounce * dims_of_vertex;
    wave.add_lights(vertex_dimension, first);
    wave.scatter(vertex_dimension, first);
  }
  wave.add_last_emission();
  return wave.results.data();
}

const FirstPart* PathWave::first_parts() const {
  return buffers_->first_parts.data();
}

}  // namespace umax
