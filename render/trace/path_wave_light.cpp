// The light that the paths of a wave bring back: what their rays meet by themselves, and the lights that are looked for.
#include <algorithm>
#include <cmath>

#include "render/trace/path_wave_buffers.h"

namespace umax {

using namespace rows;

namespace {

// weight of one of two strategies that could have found the same light [Veach 1995, power heuristic]
inline float strategy_weight(float own_density, float other_density) {
  const float own = own_density * own_density, other = other_density * other_density;
  return own / (own + other);
}

}  // namespace

// --- light that a ray itself meets
// A rectangle in front of the surface, or the sky behind everything. False: nothing more to follow. Rectangles hide
// what is behind them from the camera only: shadow rays pass through them, too.
void PathWave::Buffers::add_emissions(bool from_camera) {
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

void PathWave::Buffers::add_sky(int i, bool from_camera) {
  Vector3f& radiance = results[slot[i]].radiance;
  if (from_camera) {
    radiance += behind_everything(i);
  } else {
    radiance += throughput.vector(i).cwiseProduct(sky_seen(i));
  }
}

// what a camera sees where there is nothing else
Vector3f PathWave::Buffers::behind_everything(int i) const {
  if (tracer.backdrop) return *tracer.backdrop;
  const Vector3f towards = ray.direction.vector(i);
  return tracer.sky.radiance(tracer.fades.empty() ? towards : at_or_above_horizon(towards));
}

// A path that meets a ground that fades sees both shares at once, so that no chance decides between them.
void PathWave::Buffers::fade_out() {
  keep([&](int i) {
    const std::optional<Fade>& fade = tracer.fades[hit.object[i]];
    const float share = fade ? fade->at(ray.origin.vector(i) + hit.distance[i] * ray.direction.vector(i)) : 0;
    if (!(share > 0)) return true;
    results[slot[i]].radiance += share * behind_everything(i);
    throughput.set(i, {1 - share, 1 - share, 1 - share});
    return share < 1;
  });
}

void PathWave::Buffers::add_rectangle(int i, bool from_camera) {
  float share = 1;
  const RectangleLights::Met here{.light = met.light[i], .distance = met.distance[i]};
  if (!from_camera)
    share = strategy_weight(density[i], tracer.lights.density(here, ray.origin.vector(i), ray.direction.vector(i)));
  results[slot[i]].radiance += share * throughput.vector(i).cwiseProduct(tracer.lights.radiance(here.light));
}

Vector3f PathWave::Buffers::sky_seen(int i) const {
  if (sight[i] != Sight::none && tracer.shows_backdrop) return behind_everything(i);
  const Vector3f towards = ray.direction.vector(i), radiance = tracer.sky.radiance(towards);
  if (!tracer.sky.is_aimed()) return radiance;
  return strategy_weight(density[i], tracer.sky.density(towards)) * radiance;
}

// after the last bounce only light counts, so whether anything is in the way is enough to know
void PathWave::Buffers::add_last_emission() {
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

// --- lights that are looked for
void PathWave::Buffers::add_lights(int vertex_dimension, bool first) {
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

void PathWave::Buffers::add_light_samples(bool first) {
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

}  // namespace umax
