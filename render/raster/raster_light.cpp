#include "render/raster/raster_light.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/base/error.h"
#include "core/base/srgb.h"
#include "render/scene/daylight.h"
#include "render/scene/latlong.h"
#include "render/scene/light.h"

namespace umax::raster {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr int probe_width = 128, probe_height = 64;     // [px] the sharpest surroundings
constexpr int blurred_width = 64, blurred_height = 32;  // [px] what is filtered for rough surfaces
constexpr float shaded_ground =
    0.7f;  // share of the ground's light that reaches a body which shades the ground under it

/// A latitude-longitude picture of a function of direction.
template <class Radiance>
Image latlong_image(int width, int height, const Radiance& radiance) {
  Image image(width, height, 3);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 4), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < width; ++x)
        Eigen::Map<Vector3f>(image.pixel(x, y)) =
            radiance(direction_of_latlong((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height)));
  });
  return image;
}

float solid_angle(const Image& image, int y) {
  const float h = float(image.height), w = float(image.width);
  return 2 * pi / w * (std::cos(pi * float(y) / h) - std::cos(pi * float(y + 1) / h));
}

// ---- shadow maps ------------------------------------------------------------------------------------------------

Matrix4f unit_from_clip() {
  Matrix4f m = Matrix4f::Identity() * 0.5f;
  m(3, 3) = 1;
  m.block<3, 1>(0, 3).setConstant(0.5f);
  return m;
}

/// Rows: right, up, back of a viewer that looks along -back.
Matrix4f looking(const Vector3f& eye, const Vector3f& back) {
  const Vector3f hint = std::abs(back[1]) < 0.9f ? Vector3f(0, 1, 0) : Vector3f(1, 0, 0);
  const Vector3f right = hint.cross(back).normalized(), up = back.cross(right);
  Matrix4f view = Matrix4f::Identity();
  view.block<1, 3>(0, 0) = right.transpose();
  view.block<1, 3>(1, 0) = up.transpose();
  view.block<1, 3>(2, 0) = back.transpose();
  view.block<3, 1>(0, 3) = -view.block<3, 3>(0, 0) * eye;
  return view;
}

/// Parallel light: the focus sphere fills the map.
Matrix4f parallel_shadow(const Vector3f& towards_light, const Focus& focus) {
  const float reach = 1.02f * focus.radius;
  const Vector3f scale(1 / reach, 1 / reach, -1 / reach);
  Matrix4f clip = Matrix4f::Identity();
  clip.diagonal().head<3>() = scale;
  return unit_from_clip() * clip * looking(focus.center, towards_light);
}

/// Light from a point: the cone around the focus sphere, at most 150 degrees wide. Returns its half-width's tangent
/// too.
std::pair<Matrix4f, float> point_shadow(const Vector3f& from, const Focus& focus) {
  const Vector3f back = from - focus.center;
  const float distance = std::max(back.norm(), 1e-4f * focus.radius);
  const float sine = std::min(1.02f * focus.radius / distance, 0.966f);
  const float tangent = sine / std::sqrt(1 - sine * sine);
  const float near_plane = std::max(distance - 1.02f * focus.radius, 0.02f * focus.radius),
              far_plane = distance + 1.02f * focus.radius;
  Matrix4f clip = Matrix4f::Zero();
  clip(0, 0) = clip(1, 1) = 1 / tangent;
  clip(2, 2) = (far_plane + near_plane) / (near_plane - far_plane);
  clip(2, 3) = 2 * far_plane * near_plane / (near_plane - far_plane);
  clip(3, 2) = -1;
  const Vector3f axis = back.norm() > 0 ? Vector3f(back.normalized()) : Vector3f(0, 1, 0);
  return {unit_from_clip() * clip * looking(from, axis), tangent};
}

// ---- lights with highlights -------------------------------------------------------------------------------------

/// The i-th of n points spread evenly over the unit square, all different on both axes.
Vector2f spread_point(int i, int n) {
  const float golden = 0.61803399f * float(i) + 0.5f;
  return {(float(i) + 0.5f) / float(n), golden - std::floor(golden)};
}

void add_area_light(const AreaLight& light, int count, const Focus& focus, Frame& frame) {
  const Vector3f normal = light.edge_u.cross(light.edge_v);
  const float area = normal.norm();
  if (!(area > 0)) return;
  frame.key_lights.push_back(
      {true, light.corner, light.edge_u, light.edge_v, light.radiance, int(frame.key_samples.size()), count});
  for (int i = 0; i < count; ++i) {
    const Vector2f uv = spread_point(i, count);
    const Vector3f from = light.corner + uv[0] * light.edge_u + uv[1] * light.edge_v;
    const auto [shadow, tangent] = point_shadow(from, focus);
    const float texel = 2 * tangent / float(frame.key_map_size);
    frame.key_samples.push_back({shadow, from, true, light.radiance * (area / float(count)), normal / area, texel});
  }
}

void add_sun(const Daylight& daylight, int count, const Focus& focus, Frame& frame) {
  const Vector3f irradiance = daylight.sun_radiance * daylight.sun_solid_angle;
  const Matrix4f frame_of_sun = looking(Vector3f::Zero(), daylight.sun_direction);
  frame.key_lights.push_back(
      {false, daylight.sun_direction, {0, 0, 0}, {0, 0, 0}, irradiance, int(frame.key_samples.size()), count});
  const float texel = 2.04f * focus.radius / float(frame.key_map_size);
  for (int i = 0; i < count; ++i) {
    const Vector2f uv = spread_point(i, count);
    const float cosine = 1 - uv[0] * (1 - daylight.sun_cosine), sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
    const Vector3f local(sine * std::cos(2 * pi * uv[1]), sine * std::sin(2 * pi * uv[1]), cosine);
    const Vector3f towards = frame_of_sun.block<3, 3>(0, 0).transpose() * local;
    frame.key_samples.push_back(
        {parallel_shadow(towards, focus), towards, false, irradiance / float(count), {0, 1, 0}, texel});
  }
}

/// The sun as a key light and as the disc that the camera sees.
void add_sun_of(const Sky& sky, int count, const Focus& focus, Frame& frame) {
  const auto* kind = std::get_if<DaylightSky>(&sky);
  if (!kind) return;
  const Daylight daylight(*kind);
  if (!(daylight.sun_radiance.maxCoeff() > 0)) return;
  add_sun(daylight, count, focus, frame);
  frame.sun << daylight.sun_direction, daylight.sun_cosine;
  frame.sun_radiance = daylight.sun_radiance;
}

/// Radiance of the sky without the sun, which is a light of its own.
std::function<Vector3f(const Vector3f&)> make_dome(const Sky& sky) {
  if (const auto* kind = std::get_if<DaylightSky>(&sky))
    return [daylight = Daylight(*kind)](const Vector3f& d) { return daylight.dome(d); };
  return [light = std::make_shared<SkyLight>(sky)](const Vector3f& d) { return light->radiance(d); };
}

// ---- sky --------------------------------------------------------------------------------------------------------

/// Directions spread evenly over a hemisphere (up = 1 or -1).
std::vector<Vector3f> hemisphere(int count, float up) {
  std::vector<Vector3f> directions;
  for (int i = 0; i < count; ++i) {
    const float y = (float(i) + 0.5f) / float(count), r = std::sqrt(1 - y * y), azimuth = 2.39996323f * float(i);
    directions.push_back({r * std::cos(azimuth), up * y, r * std::sin(azimuth)});
  }
  return directions;
}

/// Shares the surroundings' light out among directions, each placed where its share comes from on average.
void add_sky(const Image& surroundings, int count, const Focus& focus, Frame& frame) {
  std::vector<Vector3f> directions = hemisphere(count - count / 3, 1);
  for (const Vector3f& direction : hemisphere(count / 3, -1)) directions.push_back(direction);
  std::vector<Vector3f> irradiance(directions.size(), Vector3f::Zero()), mean(directions.size(), Vector3f::Zero());
  for (int y = 0; y < surroundings.height; ++y) {
    for (int x = 0; x < surroundings.width; ++x) {
      const Vector3f d = direction_of_latlong((float(x) + 0.5f) / float(surroundings.width),
                                              (float(y) + 0.5f) / float(surroundings.height));
      // the nearest direction of the same hemisphere
      std::size_t nearest = d[1] > 0 ? 0 : std::size_t(count - count / 3);
      const std::size_t end = d[1] > 0 ? nearest + std::size_t(count - count / 3) : directions.size();
      for (std::size_t i = nearest + 1; i < end; ++i)
        if (directions[i].dot(d) > directions[nearest].dot(d)) nearest = i;
      const Vector3f arriving = Eigen::Map<const Vector3f>(surroundings.pixel(x, y)) * solid_angle(surroundings, y);
      irradiance[nearest] += arriving;
      mean[nearest] += d * luminance(arriving[0], arriving[1], arriving[2]);
    }
  }
  const float texel = 2.04f * focus.radius / float(frame.sky_map_size);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (!(mean[i].norm() > 0)) continue;
    const Vector3f towards = mean[i].normalized();
    frame.sky_samples.push_back({parallel_shadow(towards, focus), towards, false, irradiance[i], {0, 1, 0}, texel});
  }
}

// ---- surroundings as seen in surfaces -----------------------------------------------------------------------------

/// Mean of the surroundings over the GGX lobe about each direction.
Image blurred(const Image& source, float roughness) {
  const float alpha = roughness * roughness, a2 = alpha * alpha;
  std::vector<Vector3f> directions;
  std::vector<float> solid_angles;  // of a pixel in each row
  for (int y = 0; y < source.height; ++y) solid_angles.push_back(solid_angle(source, y));
  for (int y = 0; y < source.height; ++y)
    for (int x = 0; x < source.width; ++x)
      directions.push_back(
          direction_of_latlong((float(x) + 0.5f) / float(source.width), (float(y) + 0.5f) / float(source.height)));
  return latlong_image(source.width, source.height, [&](const Vector3f& axis) {
    Vector3f sum = Vector3f::Zero();
    float weights = 0;
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const float cosine = axis.dot(directions[i]);
      if (cosine <= 0) continue;
      // the half vector lies at half the angle
      const float n_h2 = 0.5f * (1 + cosine), d = n_h2 * (a2 - 1) + 1;
      const float weight = a2 / (d * d) * cosine * solid_angles[i / std::size_t(source.width)];
      sum += weight * Eigen::Map<const Vector3f>(&source.values[3 * i]);
      weights += weight;
    }
    return Vector3f(sum / weights);
  });
}

Image resized(const Image& source, int width, int height) {
  return latlong_image(width, height, [&](const Vector3f& d) { return look_up_latlong(source, latlong_of(d)); });
}

/// The surroundings from the sharpest to the most blurred.
std::vector<Image> blurred_layers(const Image& sharp) {
  std::vector<Image> layers{sharp};
  const Image small = resized(sharp, blurred_width, blurred_height);
  for (int layer = 1; layer < num_probe_layers; ++layer) {
    const float roughness = float(layer) / float(num_probe_layers - 1);
    layers.push_back(resized(blurred(small, roughness), sharp.width, sharp.height));
  }
  return layers;
}

/// Sets all directions that point down.
void fill_below(Image& surroundings, const Vector3f& radiance) {
  for (int y = probe_height / 2; y < probe_height; ++y)
    for (int x = 0; x < probe_width; ++x) Eigen::Map<Vector3f>(surroundings.pixel(x, y)) = radiance;
}

/// The layers of these surroundings, which are dark below where there is a ground.
void fill_cache(const Image& sharp, bool has_ground, ProbeCache& cache) {
  if (cache.sharp.values == sharp.values && cache.ground_layers.empty() != has_ground) return;
  cache.sharp = sharp;
  cache.layers = blurred_layers(sharp);
  cache.ground_layers.clear();
  if (!has_ground) return;
  Image ground(probe_width, probe_height, 3);
  fill_below(ground, Vector3f::Ones());
  cache.ground_layers = blurred_layers(ground);
}

std::vector<Image> probe_over(const ProbeCache& cache, const Vector3f& bounce) {
  std::vector<Image> probe = cache.layers;
  for (std::size_t layer = 0; layer < cache.ground_layers.size(); ++layer)
    for (std::size_t i = 0; i < probe[layer].values.size(); ++i)
      probe[layer].values[i] += bounce[Eigen::Index(i % 3)] * cache.ground_layers[layer].values[i];
  return probe;
}

/// What the ground sends back: its colour in the light of the sky and of the lights above the focus.
Vector3f ground_radiance(const Ground& ground, const Image& sky, const Focus& focus, const Frame& frame) {
  Vector3f irradiance = Vector3f::Zero();
  for (int y = 0; y < sky.height / 2; ++y) {
    const float cosine = std::cos(pi * (float(y) + 0.5f) / float(sky.height));
    for (int x = 0; x < sky.width; ++x)
      irradiance += Eigen::Map<const Vector3f>(sky.pixel(x, y)) * (cosine * solid_angle(sky, y));
  }
  const Vector3f here(focus.center[0], ground.height, focus.center[2]);
  for (const LightSample& sample : frame.key_samples) {
    const Vector3f to_light = sample.is_point ? Vector3f(sample.position - here) : sample.position;
    const float distance2 = to_light.squaredNorm();
    const Vector3f l = to_light / std::sqrt(distance2);
    const float emitted = sample.is_point ? std::max(-l.dot(sample.axis), 0.0f) / distance2 : 1;
    irradiance += sample.power * (std::max(l[1], 0.0f) * emitted);
  }
  return shaded_ground / pi * ground.color.cwiseProduct(irradiance);
}

}  // namespace

void prepare_lighting(const RenderScene& scene, const Focus& focus, const Ground& ground,
                      const LightingOptions& options, ProbeCache& cache, Frame& frame) {
  const bool has_sun = std::holds_alternative<DaylightSky>(scene.sky);
  const int num_lights = int(scene.lights.size()) + int(has_sun);
  if (num_lights > max_key_lights) {
    throw Error(Fault::bad_data, {"rasteriser", "draws at most " + std::to_string(max_key_lights) + " lights",
                                  std::to_string(num_lights), "remove some, or use --engine embree"});
  }
  const int share = std::clamp(options.light_samples, 1, max_key_samples / std::max(num_lights, 1));
  for (const AreaLight& light : scene.lights) add_area_light(light, share, focus, frame);
  add_sun_of(scene.sky, share, focus, frame);

  const auto sky = make_dome(scene.sky);
  Image surroundings = latlong_image(probe_width, probe_height, sky);
  Vector3f bounce = Vector3f::Zero();
  if (ground.present) {
    bounce = ground_radiance(ground, surroundings, focus, frame);
    fill_below(surroundings, Vector3f::Zero());
  }
  fill_cache(surroundings, ground.present, cache);
  if (ground.present) fill_below(surroundings, bounce);
  add_sky(surroundings, std::clamp(options.sky_samples, 8, max_sky_samples), focus, frame);
  frame.probe = probe_over(cache, bounce);

  if (scene.backdrop) {
    frame.background = Image(1, 1, 3);
    Eigen::Map<Vector3f>(frame.background.pixel(0, 0)) = *scene.backdrop;
  } else {
    frame.background = latlong_image(1024, 512, sky);
  }
}

}  // namespace umax::raster
