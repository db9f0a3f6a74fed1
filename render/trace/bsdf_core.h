// The arithmetic of render/trace/bsdf.h on plain numbers without branches: one source for one direction at a time and
// for loops over many, which compilers turn into vector code. Same operations, so the same bits either way.
#pragma once

#include <cmath>

#include "render/scene/fast_math.h"
#include "render/scene/rows.h"

namespace umax::bsdf_core {

constexpr float pi = 3.14159265f;
constexpr float inverse_pi = 0.318309886f;
constexpr float below_one = 0.99999994f;
constexpr float coat_f0 = 0.04f;

inline float larger(float a, float b) {
  return a > b ? a : b;
}
inline float smaller(float a, float b) {
  return a < b ? a : b;
}

struct Color {
  float r = 0, g = 0, b = 0;
};
inline Color operator*(float s, const Color& c) {
  return {s * c.r, s * c.g, s * c.b};
}
inline Color operator+(const Color& a, const Color& c) {
  return {a.r + c.r, a.g + c.g, a.b + c.b};
}

// sqrt(alpha^2 + (1 - alpha^2) cos^2), the root in Smith's shadowing terms
inline float smith_root(float alpha, float cosine) {
  const float alpha2 = alpha * alpha;
  return std::sqrt(alpha2 + (1 - alpha2) * cosine * cosine);
}

inline float power5(float x) {
  const float x2 = x * x;
  return x2 * x2 * x;
}

// share of a layer's light that comes back after several bounces among the facets
inline float compensation(float f0, float single_bounce) {
  return 1 + f0 * (1 - single_bounce) / single_bounce;
}

// a GGX lobe seen from one direction
struct Lobe {
  float alpha = 0.25f, root_viewer = 1, density_scale = 0.25f;
};
inline Lobe make_lobe(float alpha, float cosine_viewer) {
  const float root = smith_root(alpha, cosine_viewer);
  return {.alpha = alpha, .root_viewer = root, .density_scale = 0.5f / (cosine_viewer + root)};
}

struct LobeValue {
  float scale;    // D V cos, without the Fresnel term
  float density;  // of visible normals, mapped to directions
  float fresnel;  // (1 - c)^5
};
inline LobeValue evaluate_lobe(const Lobe& lobe, const Direction& viewer, const Direction& light) {
  // the half vector, not normalised: its length is twice the cosine between it and either direction
  const float hx = viewer.x + light.x, hy = viewer.y + light.y, hz = viewer.z + light.z;
  const float flat2 = hx * hx + hy * hy, alpha2 = lobe.alpha * lobe.alpha, length2 = flat2 + hz * hz;
  // density of microfacet normals, from the sine, which keeps its digits where the lobe is narrow
  const float t = flat2 + alpha2 * hz * hz;
  const float facets = inverse_pi * alpha2 * length2 * length2 / (t * t);
  const float root_light = smith_root(lobe.alpha, light.z);
  const float visibility = 0.5f / (light.z * lobe.root_viewer + viewer.z * root_light);
  return {.scale = facets * visibility * light.z,
          .density = facets * lobe.density_scale,
          .fresnel = power5(larger(0, 1 - 0.5f * std::sqrt(length2)))};
}

// a look at one point, seen from one direction
struct Surface {
  Direction viewer;
  Color diffuse, glossy_a, glossy_b;  // reflectance; Fresnel term glossy_a + glossy_b (1 - c)^5 with all its scales
  float coat = 0;
  Lobe glossy_lobe, coat_lobe;
  float choose_diffuse = 1, choose_glossy = 0;
  Color albedo;
};

// reflectances of the layers for light from the viewer, looked up before
struct LayerAlbedo {
  float a = 1, b = 0, coat_a = 1, coat_b = 0;
};
struct LookNumbers {
  float alpha = 0.25f, f0 = 0.04f, f90 = 1, metallic = 0, coat = 0, coat_alpha = 1e-3f;
};

// share of light that gets below coat and glossy layer of what is no metal
inline float share_below(const LookNumbers& look, const LayerAlbedo& e) {
  const float coat = look.coat * compensation(coat_f0, e.coat_a);
  const float below_coat = 1 - coat * (coat_f0 * e.coat_a + (1 - coat_f0) * e.coat_b);
  const float gain = compensation(look.f0, e.a);
  return below_coat * (1 - look.metallic) * (1 - gain * (look.f0 * e.a + (look.f90 - look.f0) * e.b));
}

inline Surface make_surface(const LookNumbers& look, const LayerAlbedo& e, const Color& base, const Direction& viewer) {
  Surface s;
  s.viewer = viewer;
  s.glossy_lobe = make_lobe(look.alpha, viewer.z);
  s.coat_lobe = make_lobe(look.coat_alpha, viewer.z);
  // the coat comes first, the rest shares what it lets through
  s.coat = look.coat * compensation(coat_f0, e.coat_a);
  const float coat_albedo = s.coat * (coat_f0 * e.coat_a + (1 - coat_f0) * e.coat_b), below_coat = 1 - coat_albedo;
  // dielectric layer over the diffuse base
  const float gain = compensation(look.f0, e.a), dielectric = below_coat * (1 - look.metallic) * gain;
  const float dielectric_albedo = gain * (look.f0 * e.a + (look.f90 - look.f0) * e.b);
  s.diffuse = (below_coat * (1 - look.metallic) * (1 - dielectric_albedo)) * base;
  // metal
  const float metal = below_coat * look.metallic;
  const Color metal_gain{metal * compensation(base.r, e.a), metal * compensation(base.g, e.a),
                         metal * compensation(base.b, e.a)};
  const float a = dielectric * look.f0, b = dielectric * (look.f90 - look.f0);
  s.glossy_a = {a + metal_gain.r * base.r, a + metal_gain.g * base.g, a + metal_gain.b * base.b};
  s.glossy_b = {b + metal_gain.r * (1 - base.r), b + metal_gain.g * (1 - base.g), b + metal_gain.b * (1 - base.b)};
  // lobes are chosen by the light they send to the viewer; none so rarely that its bright directions become sparks
  const Color glossy_albedo = e.a * s.glossy_a + e.b * s.glossy_b;
  s.albedo = s.diffuse + glossy_albedo + coat_albedo * Color{1, 1, 1};
  const float diffuse = s.diffuse.r + s.diffuse.g + s.diffuse.b, least = 0.18f * diffuse;
  const float has_glossy = look.f90 + look.metallic > 0 ? 1.0f : 0.0f, has_coat = look.coat > 0 ? 1.0f : 0.0f;
  const float glossy = has_glossy * larger(glossy_albedo.r + glossy_albedo.g + glossy_albedo.b, least);
  const float coat = has_coat * larger(3 * coat_albedo, least), total = diffuse + glossy + coat;
  const float share = total > 0 ? 1 / total : 0.0f;
  s.choose_diffuse = total > 0 ? diffuse * share : 1.0f;
  s.choose_glossy = has_coat > 0 ? glossy * share : 1 - s.choose_diffuse;
  return s;
}

struct Value {
  Color value;
  float density = 0;
};
inline Value evaluate(const Surface& s, const Direction& light) {
  const float cosine_over_pi = light.z * inverse_pi;
  const LobeValue glossy = evaluate_lobe(s.glossy_lobe, s.viewer, light);
  const LobeValue coat = evaluate_lobe(s.coat_lobe, s.viewer, light);
  const float coat_value = coat.scale * s.coat * (coat_f0 + (1 - coat_f0) * coat.fresnel);
  const float coat_share = s.coat > 0 ? 1 - s.choose_diffuse - s.choose_glossy : 0.0f;
  const float above = light.z > 0 ? 1.0f : 0.0f;
  const Color value = cosine_over_pi * s.diffuse + glossy.scale * (s.glossy_a + glossy.fresnel * s.glossy_b) +
                      (s.coat > 0 ? coat_value : 0.0f) * Color{1, 1, 1};
  const float density =
      s.choose_diffuse * cosine_over_pi + s.choose_glossy * glossy.density + coat_share * coat.density;
  return {.value = {above > 0 ? value.r : 0.0f, above > 0 ? value.g : 0.0f, above > 0 ? value.b : 0.0f},
          .density = above > 0 ? density : 0.0f};
}

// uniform square to the hemisphere with density cos / pi, keeping neighbours together
inline Direction cosine_direction(float u, float v) {
  const float a = 2 * u - 1, b = 2 * v - 1;
  const bool first = std::abs(a) > std::abs(b);
  const float radius = first ? a : b, other = first ? b : a;
  const SinCos angle = sin_cos_quarter(0.78539816f * (other / (radius != 0 ? radius : 1.0f)));
  const float along = radius * angle.cosine, across = radius * angle.sine;
  const float x = first ? along : across, y = first ? across : along;
  return {x, y, std::sqrt(larger(1 - x * x - y * y, 1e-12f))};
}

// mirrors the viewer in a visible microfacet: a cap of the sphere, seen by the stretched view direction
inline Direction mirrored_direction(float alpha, const Direction& viewer, float u, float v) {
  const float sx = alpha * viewer.x, sy = alpha * viewer.y, sz = viewer.z;
  const float shrink = 1 / std::sqrt(sx * sx + sy * sy + sz * sz);
  const float vx = sx * shrink, vy = sy * shrink, vz = sz * shrink;
  const float z = (1 - v) * (1 + vz) - vz, radius = std::sqrt(larger(1 - z * z, 0));
  const SinCos angle = sin_cos(2 * pi * u);
  const float hx = alpha * (radius * angle.cosine + vx), hy = alpha * (radius * angle.sine + vy), hz = z + vz;
  const float scale = 2 * (viewer.x * hx + viewer.y * hy + viewer.z * hz) / (hx * hx + hy * hy + hz * hz);
  return {scale * hx - viewer.x, scale * hy - viewer.y, scale * hz - viewer.z};
}

// The first number of a sample chooses the lobe and is stretched to serve again.
struct LobeChoice {
  float again = 0;
  float alpha = 0;  // of the chosen lobe; 0: the diffuse base
};
inline LobeChoice choose_lobe(const Surface& s, float u) {
  const float rest = u - s.choose_diffuse, share = 1 - s.choose_diffuse;
  const bool diffuse = rest < 0, glossy = !(s.coat > 0) || rest < s.choose_glossy;
  const float numerator = diffuse ? u : glossy ? rest : rest - s.choose_glossy;
  const float glossy_width = s.coat > 0 ? s.choose_glossy : share;
  const float width = diffuse ? s.choose_diffuse : glossy ? glossy_width : share - s.choose_glossy;
  const float alpha = glossy ? s.glossy_lobe.alpha : s.coat_lobe.alpha;
  return {.again = smaller(numerator / larger(width, 1e-12f), below_one), .alpha = diffuse ? 0.0f : alpha};
}

// one of the two directions that were made for a sample, by its choice
inline Direction select_direction(const LobeChoice& choice, const Direction& cosine, const Direction& mirrored) {
  const bool diffuse = choice.alpha == 0;
  return {diffuse ? cosine.x : mirrored.x, diffuse ? cosine.y : mirrored.y, diffuse ? cosine.z : mirrored.z};
}

}  // namespace umax::bsdf_core
