#include "render/raster/raster_shade.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/raster/raster_shadow.h"
#include "render/scene/latlong.h"

namespace umax::raster {
namespace {

constexpr float pi = std::numbers::pi_v<float>;

constexpr float occluder_light = 0.12f;  // what hides the sky sends on this share of it
constexpr float wandering_light = 0.3f;  // share of light in cloudy matter that comes out anywhere, from any side alike
constexpr float any_side = 0.25f;        // mean cosine over all directions

struct SurfacePoint {
  Vector3f world{0, 0, 0}, normal{0, 1, 0}, view{0, 0, 1};  // view: towards the eye
  Vector3f base{0.5f, 0.5f, 0.5f};
  float n_v = 1;
};

/// Light in, weighted by the cosine (diffuse) or the lobe (glossy, coat).
struct Incoming {
  Vector3f diffuse{0, 0, 0}, glossy{0, 0, 0}, coat{0, 0, 0};
};

struct ShadowMaps {
  std::vector<float> key, sky;
};

/// How much of a light sample reaches a point [0, 1]: the four nearest texels, compared and blended.
float visibility(const LightSample& sample, const float* map, int size, const Vector3f& p) {
  const Matrix4f& m = sample.shadow_from_world;
  const auto row = [&](int r) { return m(r, 0) * p[0] + m(r, 1) * p[1] + m(r, 2) * p[2] + m(r, 3); };
  float x = row(0), y = row(1), z = row(2);
  if (sample.is_point) {
    const float w = row(3);
    if (w <= 1e-6f) return 1;
    const float scale = 1 / w;
    x *= scale, y *= scale, z *= scale;
  }
  x = x * float(size) - 0.5f;
  y = y * float(size) - 0.5f;
  if (!(x >= 0 && y >= 0 && x < float(size - 1) && y < float(size - 1))) return 1;
  z = std::min(z, 1.0f);
  const int x0 = int(x), y0 = int(y);
  const float fx = x - float(x0), fy = y - float(y0);
  const float* t = map + std::size_t(y0) * size + x0;
  const auto lit = [z](float depth) { return z <= depth ? 1.0f : 0.0f; };
  const float below = lit(t[0]) + fx * (lit(t[1]) - lit(t[0]));
  const float above = lit(t[size]) + fx * (lit(t[size + 1]) - lit(t[size]));
  return below + fy * (above - below);
}

/// GGX with the height-correlated Smith term: the BRDF without its Fresnel factor.
float ggx(float n_h, float n_v, float n_l, float alpha) {
  const float a2 = alpha * alpha, d = n_h * n_h * (a2 - 1) + 1;
  const float v = n_l * std::sqrt(n_v * n_v * (1 - a2) + a2) + n_v * std::sqrt(n_l * n_l * (1 - a2) + a2);
  return a2 / (pi * d * d) * 0.5f / std::max(v, 1e-5f);
}

float fresnel_weight(float cosine) {
  const float c = 1 - std::clamp(cosine, 0.0f, 1.0f), c2 = c * c;
  return c2 * c2 * c;
}

/// Scale and bias of the reflectance for light from all around: the fit of B. Karis, "Physically Based Shading on
/// Mobile", 2014.
std::pair<float, float> all_around(float roughness, float n_v) {
  const float x = 1 - roughness, y = 0.0425f - 0.0275f * roughness;
  const float z = 1.04f - 0.572f * roughness, w = 0.022f * roughness - 0.04f;
  const float a = std::min(x * x, std::exp2(-9.28f * n_v)) * x + y;
  return {-1.04f * a + z, 1.04f * a + w};
}

/// The point of a rectangle that a mirror would show, or the nearest to it.
Vector3f mirrored_point(const KeyLight& light, const Vector3f& from, const Vector3f& r) {
  const Vector3f axis = light.edge_u.cross(light.edge_v);
  const Vector3f center = light.corner + 0.5f * (light.edge_u + light.edge_v);
  const float along = r.dot(axis), steps = (light.corner - from).dot(axis) / along;
  const Vector3f hit = std::abs(along) > 1e-6f && steps > 0 ? Vector3f(from + r * steps) : center;
  const Vector3f offset = hit - light.corner;
  const float u = std::clamp(offset.dot(light.edge_u) / light.edge_u.squaredNorm(), 0.0f, 1.0f);
  const float v = std::clamp(offset.dot(light.edge_v) / light.edge_v.squaredNorm(), 0.0f, 1.0f);
  return light.corner + u * light.edge_u + v * light.edge_v;
}

/// The highlight once per light, from its most mirror-like point, its height lowered for the light's angular size
/// (B. Karis, "Real Shading in Unreal Engine 4", 2013: representative point).
void add_highlight(const KeyLight& light, float seen, const Batch& look, const Vector3f& f0, const SurfacePoint& p,
                   Incoming& sum) {
  Vector3f l = light.corner, power = light.radiance;
  float widening = 0;
  if (light.is_rectangle) {
    const Vector3f reflected = 2 * p.normal.dot(p.view) * p.normal - p.view;
    const Vector3f to_light = mirrored_point(light, p.world, reflected) - p.world;
    const Vector3f axis = light.edge_u.cross(light.edge_v);
    const float d2 = to_light.squaredNorm(), area = axis.norm();
    l = to_light / std::sqrt(d2);
    widening = 0.5f * std::sqrt(area / (pi * d2));
    power *= std::max(-l.dot(axis), 0.0f) / d2;
  }
  const float n_l = std::min(p.normal.dot(l), 1.0f);
  if (n_l <= 0) return;
  const Vector3f h = (l + p.view).normalized();
  const float n_h = std::clamp(p.normal.dot(h), 0.0f, 1.0f), fresnel = fresnel_weight(p.view.dot(h));
  const Vector3f arriving = power * (n_l * seen);
  const auto lobe = [&](float roughness) {
    const float alpha = std::max(roughness * roughness, 0.002f), lowered = alpha / std::min(alpha + widening, 1.0f);
    return ggx(n_h, p.n_v, n_l, alpha) * lowered * lowered;
  };
  sum.glossy += lobe(look.roughness) * arriving.cwiseProduct(f0 + fresnel * (Vector3f::Ones() - f0));
  if (look.coat > 0) sum.coat += lobe(look.coat_roughness) * (0.04f + 0.96f * fresnel) * arriving;
}

void add_key_lights(const Frame& frame, const ShadowMaps& maps, const Batch& look, const Vector3f& f0,
                    const SurfacePoint& p, Incoming& sum) {
  const std::size_t map_size = std::size_t(frame.key_map_size) * frame.key_map_size;
  const float soft = wandering_light * look.subsurface;
  for (const KeyLight& light : frame.key_lights) {
    float seen = 0;
    for (int i = light.first; i < light.first + light.count; ++i) {
      const LightSample& sample = frame.key_samples[i];
      Vector3f l = sample.position;
      float emitted = 1, offset = sample.texel;
      if (sample.is_point) {
        l -= p.world;
        const float d2 = l.squaredNorm(), distance = std::sqrt(d2);
        l /= distance;
        emitted = -l.dot(sample.axis) / d2;
        offset *= distance;
      }
      if (emitted <= 0) continue;
      sum.diffuse += sample.power * (soft * any_side * emitted);
      const float n_l = p.normal.dot(l);
      if (n_l <= 0) continue;
      const Vector3f off = p.world + p.normal * (offset * (1 + 2 * (1 - n_l)));  // against self-shadowing
      const float lit = visibility(sample, &maps.key[i * map_size], frame.key_map_size, off);
      seen += lit;
      sum.diffuse += sample.power * ((1 - soft) * (lit * emitted * n_l));
    }
    if (seen > 0) add_highlight(light, seen / float(light.count), look, f0, p, sum);
  }
}

/// Adds the sky's diffuse light; returns how open the surface lies to it [0, 1].
float add_sky(const Frame& frame, const ShadowMaps& maps, const Batch& look, const SurfacePoint& p, Incoming& sum) {
  const float soft = wandering_light * look.subsurface;
  const std::size_t map_size = std::size_t(frame.sky_map_size) * frame.sky_map_size;
  float open = 0, whole = 1e-6f;
  for (std::size_t i = 0; i < frame.sky_samples.size(); ++i) {
    const LightSample& sample = frame.sky_samples[i];
    const float n_l = p.normal.dot(sample.position);
    sum.diffuse += sample.power * (soft * any_side);
    if (n_l <= 0) continue;
    const Vector3f off = p.world + p.normal * (sample.texel * (1.5f + 2 * (1 - n_l)));
    const float lit = visibility(sample, &maps.sky[i * map_size], frame.sky_map_size, off);
    sum.diffuse += sample.power * ((1 - soft) * (n_l * (lit + occluder_light * (1 - lit))));
    open += n_l * lit;
    whole += n_l;
  }
  return open / whole;
}

/// Share of a mirrored direction that is not hidden, after S. Lagarde, "Moving Frostbite to PBR", 2014.
float open_to_reflection(float open, float n_v, float roughness) {
  return std::clamp(std::pow(n_v + open, std::exp2(-16 * roughness - 1)) - 1 + open, 0.0f, 1.0f);
}

Vector3f surroundings(const Frame& frame, const Vector2f& at, float roughness) {
  const float layer = float(num_probe_layers - 1) * roughness;
  const int lower = int(layer), upper = std::min(lower + 1, num_probe_layers - 1);
  const float blend = layer - float(lower);
  return (1 - blend) * look_up_latlong(frame.probe[lower], at) + blend * look_up_latlong(frame.probe[upper], at);
}

Vector3f background(const Frame& frame, const Vector3f& direction) {
  const Vector3f sky = look_up_latlong(frame.background, latlong_of(direction));
  const float edge = 0.15f * (1 - frame.sun[3]) + 1e-7f;
  const float s = std::clamp((direction.dot(frame.sun.head<3>()) - frame.sun[3] + edge) / (2 * edge), 0.0f, 1.0f);
  return sky + frame.sun_radiance * (s * s * (3 - 2 * s));
}

/// Where the eye looks through a clear body, taken for a ball: a ray is bent alike where it enters and where it leaves.
Vector3f seen_through(const SurfacePoint& p, float ior) {
  const float sine = std::sqrt(std::max(0.0f, 1 - p.n_v * p.n_v));
  const float turn = 2 * (std::asin(std::min(sine, 1.0f)) - std::asin(std::min(sine / ior, 1.0f)));
  const Vector3f across = p.n_v * p.view - p.normal;  // in the plane of both, at right angles to the view
  const float length = across.norm();
  return length > 1e-6f ? Vector3f(-std::cos(turn) * p.view + (std::sin(turn) / length) * across) : Vector3f(-p.view);
}

Vector3f shade_surface(const Frame& frame, const ShadowMaps& maps, const Batch& look, const SurfacePoint& p) {
  const Vector3f f0 =
      Vector3f::Constant(look.reflectance) + look.metallic * (p.base - Vector3f::Constant(look.reflectance));
  Incoming sum;
  add_key_lights(frame, maps, look, f0, p, sum);
  const float open = add_sky(frame, maps, look, p, sum);

  const Vector3f reflected = 2 * p.normal.dot(p.view) * p.normal - p.view;
  const Vector2f at = latlong_of(reflected);
  const auto [scale, bias] = all_around(look.roughness, p.n_v);
  const Vector3f reflectance = f0 * scale + Vector3f::Constant(bias);
  sum.glossy += surroundings(frame, at, look.roughness).cwiseProduct(reflectance) *
                open_to_reflection(open, p.n_v, look.roughness);
  Vector3f diffuse =
      (1 - look.metallic) / pi * p.base.cwiseProduct(Vector3f::Ones() - reflectance).cwiseProduct(sum.diffuse);
  if (look.transmission > 0) {
    const Vector3f beyond = surroundings(frame, latlong_of(seen_through(p, look.ior)), look.roughness);
    diffuse +=
        look.transmission *
        ((1 - look.metallic) * p.base.cwiseProduct(Vector3f::Ones() - reflectance).cwiseProduct(beyond) - diffuse);
  }
  if (!(look.coat > 0)) return diffuse + sum.glossy;

  const auto [coat_scale, coat_bias] = all_around(look.coat_roughness, p.n_v);
  const float coat = 0.04f * coat_scale + coat_bias, through = 1 - look.coat * coat;
  sum.coat +=
      surroundings(frame, at, look.coat_roughness) * (coat * open_to_reflection(open, p.n_v, look.coat_roughness));
  return through * through * (diffuse + sum.glossy) + look.coat * sum.coat;
}

/// Where a wide ground ends the horizon goes on.
Vector3f seen_background(const Frame& frame, const Vector3f& direction) {
  return background(frame, frame.ground_fade ? at_or_above_horizon(direction) : direction);
}

/// A wide ground passes into what lies at the horizon.
Vector3f faded(const Frame& frame, const SurfacePoint& p, const Vector3f& color) {
  const float share = frame.ground_fade ? frame.ground_fade->at(p.world) : 0;
  return share > 0 ? Vector3f(color + share * (seen_background(frame, -p.view) - color)) : color;
}

// ---- the samples of a pixel ---------------------------------------------------------------------------------------

struct Surface {
  Vector3f normal{0, 0, 0}, base{0, 0, 0};
  float distance = 0;
  int batch = -1, count = 0;
};

/// The surfaces that a pixel's samples show: neighbouring triangles of one smooth surface are one.
int gather_surfaces(const Visible& visible, int x, int y, std::array<Surface, samples_per_pixel>& surfaces) {
  int num_surfaces = 0;
  for (int s = 0; s < samples_per_pixel; ++s) {
    const std::size_t at = 4 * ((std::size_t(s) * visible.height + y) * visible.width + x);
    const float* g = &visible.geometry[at];
    const float* m = &visible.material[at];
    const int batch = int(m[3]) - 1;
    const Eigen::Map<const Vector3f> normal(g), base(m);
    int k = 0;
    for (; k < num_surfaces; ++k) {
      const Surface& other = surfaces[k];
      if (other.batch != batch) continue;
      const float n = float(other.count);
      if (batch < 0 ||
          (normal.dot(other.normal) > 0.93f * n && std::abs(g[3] * n - other.distance) < 0.01f * other.distance))
        break;
    }
    if (k == num_surfaces) surfaces[num_surfaces++] = Surface{.batch = batch};
    Surface& surface = surfaces[k];
    surface.normal += normal;
    surface.base += base;
    surface.distance += g[3];
    ++surface.count;
  }
  return num_surfaces;
}

Vector3f shade_pixel(const Frame& frame, const ShadowMaps& maps, const Visible& visible, int x, int y) {
  const Vector4f clip(2 * (float(x) + 0.5f) / float(visible.width) - 1,
                      1 - 2 * (float(y) + 0.5f) / float(visible.height), 1, 1);
  const Vector4f far_point = frame.world_from_clip * clip;
  const Vector3f direction = (far_point.head<3>() / far_point[3] - frame.eye).normalized();

  std::array<Surface, samples_per_pixel> surfaces;
  const int num_surfaces = gather_surfaces(visible, x, y, surfaces);
  Vector3f sum(0, 0, 0);
  float weights = 0;
  for (int k = 0; k < num_surfaces; ++k) {
    const Surface& surface = surfaces[k];
    Vector3f color;
    if (surface.batch < 0) {
      color = seen_background(frame, direction);
    } else {
      const float share = 1 / float(surface.count);
      SurfacePoint p;
      p.view = -direction;
      p.normal = surface.normal.normalized();
      if (!(p.normal.squaredNorm() > 0.5f)) p.normal = p.view;  // a mesh whose normals are none
      p.world = frame.eye + direction * (surface.distance * share);
      p.base = surface.base * share;
      p.n_v = std::max(p.normal.dot(p.view), 1e-3f);
      const Batch& look = frame.batches[surface.batch];
      color = shade_surface(frame, maps, look, p);
      if (look.is_ground) color = faded(frame, p, color);
    }
    // edges against highlights stay smooth when bright surfaces weigh less
    const float weight = float(surface.count) / (1 + color.maxCoeff());
    sum += weight * color;
    weights += weight;
  }
  return sum / weights;
}

}  // namespace

Image shade(const Frame& frame, const Visible& visible) {
  const ShadowMaps maps{draw_shadow_maps(frame, frame.key_samples, frame.key_map_size),
                        draw_shadow_maps(frame, frame.sky_samples, frame.sky_map_size)};
  Image image(visible.width, visible.height, 3);
  tbb::parallel_for(tbb::blocked_range<int>(0, visible.height, 4), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int x = 0; x < visible.width; ++x) {
        Eigen::Map<Vector3f> pixel(image.pixel(x, y));
        pixel = shade_pixel(frame, maps, visible, x, y);
        if (visible.wires.values.empty()) continue;
        const float* wire = visible.wires.pixel(x, y);
        pixel = (1 - wire[3]) * pixel + Eigen::Map<const Vector3f>(wire);
      }
    }
  });
  return image;
}

}  // namespace umax::raster
