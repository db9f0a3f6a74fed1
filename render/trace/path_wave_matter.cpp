// Paths of a wave that enter bodies: chance decides whether a path stays at the surface or goes below it. Below, it is
// led path by path to where it gets out: there cloudy matter goes on as a matt white surface, clear matter as a ray.
#include <algorithm>
#include <cmath>

#include "render/trace/path_wave_buffers.h"

namespace umax {

using namespace rows;

namespace {

// of rays that no light could have been aimed along: above every density of aimed ones, and its square is finite
constexpr float sure_density = 1e18f;

// neither the surface nor what is below it gets fewer paths than this
constexpr float least_chance = 0.1f;

float brightness(const Vector3f& color) {
  return color.maxCoeff();
}

}  // namespace

void PathWave::Buffers::enter_matter(int bounce) {
  draw(matter_dimension(bounce), u, v);
  draw(matter_dimension(bounce) - matter_bounces, inner_u, inner_v);
  bool any_exit = false;
  for (int i = 0; i < count; ++i) {
    fate[i] = Fate::stays;
    const Matter& matter = tracer.matters[hit.object[i]];
    if (!matter.lets_light_in()) continue;
    const Vector3f face = tracer.rays.objects()[hit.object[i]].face(hit.triangle[i], ray.time[i]);
    if (face.dot(ray.direction.vector(i)) > 0) {
      if (matter.transmission > 0) pass(i, matter, bounce);
    } else {
      choose_fate(i, matter, bounce);
    }
    any_exit |= fate[i] == Fate::comes_out;
  }
  if (any_exit) surface_points.find(tracer.rays.objects(), ray, hit, count, point);
  for (int i = 0; i < count; ++i) {
    if (fate[i] == Fate::stays) continue;
    const Frame axes(point.normal.vector(i));
    frame.x.set(i, axes.x), frame.y.set(i, axes.y), frame.z.set(i, axes.z);
    surface.set(i, {.viewer = {0, 0, 1},
                    .diffuse = fate[i] == Fate::comes_out ? bsdf_core::Color{1, 1, 1} : bsdf_core::Color{0, 0, 0}});
  }
}

// of a path that comes from outside
void PathWave::Buffers::choose_fate(int i, const Matter& matter, int bounce) {
  const bsdf_core::LayerAlbedo layers{
      .a = look.a[i], .b = look.b[i], .coat_a = look.coat_a[i], .coat_b = look.coat_b[i]};
  const float below = bsdf_core::share_below(tracer.looks[hit.object[i]].numbers, layers);
  const Vector3f base(point.base_color.r[i], point.base_color.g[i], point.base_color.b[i]);
  const float clear = below * matter.transmission, cloudy = below * (1 - matter.transmission) * matter.subsurface;
  const float matt = (1 - matter.transmission) * (1 - matter.subsurface);
  const Vector3f diffuse = surface.diffuse.vector(i), above = surface.albedo.vector(i) - diffuse;
  const float at_surface = std::max(0.0f, brightness(above)) + matt * brightness(diffuse);
  const float enters = clear + cloudy * brightness(base);
  if (!(enters > 0)) return;
  const float chance =
      at_surface > 1e-4f ? std::clamp(enters / (enters + at_surface), least_chance, 1 - least_chance) : 1.0f;
  surface.diffuse.set(i, matt * surface.diffuse.at(i));
  if (u[i] >= chance) {
    throughput.set(i, (1 / (1 - chance)) * throughput.at(i));
    return;
  }
  // both kinds of matter by what they bring back
  const float again = u[i] / chance, is_clear = clear / enters;
  if (again < is_clear) {
    throughput.set(i, (clear / (chance * is_clear)) * throughput.at(i));
    pass(i, matter, bounce);
  } else {
    throughput.set(i, (cloudy / (chance * (1 - is_clear))) * throughput.at(i));
    walk(i, matter, base, bounce);
  }
}

void PathWave::Buffers::walk(int i, const Matter& matter, const Vector3f& base, int bounce) {
  PathRandom random(reversed_index[i], block_key[i], std::uint32_t(bounce));
  const Walk way = wander(tracer.rays, matter, base, ray.at(i), hit.at(i), {inner_u[i], inner_v[i]}, random);
  const Vector3f carried = throughput.vector(i).cwiseProduct(way.weight);
  throughput.set(i, {carried.x(), carried.y(), carried.z()});
  hit.set(i, way.exit);
  ray.direction.set(i, Vector3f(-way.outwards));
  sight[i] = Sight::none;
  fate[i] = Fate::comes_out;
}

void PathWave::Buffers::pass(int i, const Matter& matter, int bounce) {
  PathRandom random(reversed_index[i], block_key[i], std::uint32_t(bounce));
  const Vector3f color(point.base_color.r[i], point.base_color.g[i], point.base_color.b[i]);
  const Passage way = pass_through(tracer.rays, matter, color, ray.at(i), hit.at(i), {inner_u[i], inner_v[i]}, random);
  const Vector3f carried = throughput.vector(i).cwiseProduct(way.weight);
  beyond.set(i, way.ray);
  beyond.max_distance[i] = std::numeric_limits<float>::infinity();
  beyond_throughput.set(i, {carried.x(), carried.y(), carried.z()});
  fate[i] = Fate::passes;
  const bool is_seen = bounce == 0 || sight[i] != Sight::none;
  if (is_seen && matter.is_smooth && (bounce == 0 || sight[i] == Sight::sharp)) {
    // what is seen through it guides the filter: until something is met, nothing
    sight[i] = Sight::sharp;
    results[slot[i]].albedo = {1, 1, 1};
    results[slot[i]].normal = {0, 0, 0};
  } else if (is_seen) {
    sight[i] = Sight::blurred;
  }
}

// in place of the directions that scatter() has chosen for paths that pass
void PathWave::Buffers::go_through() {
  for (int i = 0; i < count; ++i) {
    if (fate[i] != Fate::passes) {
      sight[i] = Sight::none;
      continue;
    }
    ray.copy(i, i, beyond);
    throughput.set(i, beyond_throughput.at(i));
    density[i] = sure_density;
    goes_on[i] = brightness(throughput.vector(i)) > 0 ? 1 : 0;
  }
}

// Where a ground fades, paths that have only passed through clear matter see both shares, like those from the camera.
void PathWave::Buffers::fade_through() {
  if (tracer.fades.empty()) return;
  for (int i = 0; i < count; ++i) {
    const std::optional<Fade>& fade = tracer.fades[hit.object[i]];
    if (sight[i] == Sight::none || !fade) continue;
    const float share = fade->at(ray.origin.vector(i) + hit.distance[i] * ray.direction.vector(i));
    results[slot[i]].radiance += share * throughput.vector(i).cwiseProduct(behind_everything(i));
    throughput.set(i, (1 - share) * throughput.at(i));
  }
}

// what paths show that have only passed through clear matter
void PathWave::Buffers::guide_through() {
  for (int i = 0; i < count; ++i) {
    if (sight[i] != Sight::sharp) continue;
    PathResult& result = results[slot[i]];
    const Vector3f tint = throughput.vector(i).cwiseMin(1.0f);
    result.albedo = tint.cwiseProduct(surface.albedo.vector(i));
    result.normal = point.normal.vector(i);
  }
}

}  // namespace umax
