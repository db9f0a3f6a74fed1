#include "render/bsdf.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.h"
#include "render/fast_math.h"
#include "render/sampling.h"
#include "render/srgb.h"

namespace umax {
namespace {

constexpr float pi = 3.14159265f;
constexpr float inverse_pi = 0.318309886f;

float power5(float x) {
  const float x2 = x * x;
  return x2 * x2 * x;
}

// sqrt(alpha^2 + (1 - alpha^2) cos^2), the root in Smith's shadowing terms
float smith_root(float alpha, float cosine) {
  const float alpha2 = alpha * alpha;
  return std::sqrt(alpha2 + (1 - alpha2) * cosine * cosine);
}

Vector3f sample_visible_normal(float alpha, const Vector3f& to_viewer, const Vector2f& u) {
  // a cap of the sphere, seen by the stretched view direction
  const Vector3f stretched = Vector3f(alpha * to_viewer.x(), alpha * to_viewer.y(), to_viewer.z()).normalized();
  const float z = (1 - u.y()) * (1 + stretched.z()) - stretched.z();
  const float radius = std::sqrt(std::clamp(1 - z * z, 0.0f, 1.0f));
  const SinCos angle = sin_cos(2 * pi * u.x());
  const Vector3f half = Vector3f(radius * angle.cosine, radius * angle.sine, z) + stretched;
  return Vector3f(alpha * half.x(), alpha * half.y(), half.z()).normalized();
}

struct LobeValue {
  float scale;    // D V cos, without the Fresnel term
  float density;  // of visible normals, mapped to directions
  float fresnel;  // (1 - c)^5
};

LobeValue evaluate_lobe(const Bsdf::Lobe& lobe, const Vector3f& to_viewer, const Vector3f& to_light) {
  // the half vector, not normalised: its length is twice the cosine between it and either direction
  const Vector3f half = to_viewer + to_light;
  const float alpha2 = lobe.alpha * lobe.alpha, length2 = half.squaredNorm();
  // density of microfacet normals, from the sine, which keeps its digits where the lobe is narrow
  const float flat2 = half.x() * half.x() + half.y() * half.y();
  const float t = flat2 + alpha2 * half.z() * half.z();
  const float facets = inverse_pi * alpha2 * length2 * length2 / (t * t);
  const float root_light = smith_root(lobe.alpha, to_light.z());
  const float visibility = 0.5f / (to_light.z() * lobe.root_viewer + to_viewer.z() * root_light);
  return {.scale = facets * visibility * to_light.z(),
          .density = facets * lobe.density_scale,
          .fresnel = power5(std::max(0.0f, 1 - 0.5f * std::sqrt(length2)))};
}

Vector3f reflect(const Vector3f& direction, const Vector3f& normal) {
  return 2 * direction.dot(normal) * normal - direction;
}

void check_unit_range(float value, const std::string& where, const char* key) {
  if (value >= 0 && value <= 1) return;
  throw Error(ExitCode::bad_data, {.where = where + ": " + key,
                                   .what = "must lie between 0 and 1",
                                   .value = std::to_string(value),
                                   .remedy = "give a value in that range"});
}

float alpha_of(float roughness) {
  return std::max(roughness * roughness, 4e-4f);
}

// F0 of the boundary between air and a dielectric
float reflectance_at_normal(float ior) {
  const float r = (ior - 1) / (ior + 1);
  return r * r;
}

// share of a layer's light that comes back after several bounces among the facets
float compensation(float f0, float single_bounce) {
  return 1 + f0 * (1 - single_bounce) / single_bounce;
}

Bsdf::Lobe make_lobe(float alpha, float cosine_viewer) {
  const float root = smith_root(alpha, cosine_viewer);
  return {.alpha = alpha, .root_viewer = root, .density_scale = 0.5f / (cosine_viewer + root)};
}

}  // namespace

GlossyAlbedo::GlossyAlbedo(float alpha) {
  constexpr int num_samples = 128;
  const SampleSequence sequence(num_samples, 7);
  for (int i = 0; i < num_nodes; ++i) {
    // nodes are denser towards grazing angles
    const float cosine = std::max(float(i * i) / float((num_nodes - 1) * (num_nodes - 1)), 1e-5f);
    const Vector3f to_viewer(std::sqrt(std::max(0.0f, 1 - cosine * cosine)), 0, cosine);
    double a = 0, b = 0;
    for (int s = 0; s < num_samples; ++s) {
      const Vector3f half = sample_visible_normal(alpha, to_viewer, sequence.point(unsigned(s), i, 0));
      const Vector3f to_light = reflect(to_viewer, half);
      if (to_light.z() <= 0) continue;
      // what is left of G2 / G1 after sampling visible normals
      const float root_viewer = smith_root(alpha, cosine), root_light = smith_root(alpha, to_light.z());
      const float weight = to_light.z() * (cosine + root_viewer) / (to_light.z() * root_viewer + cosine * root_light);
      a += double(weight);
      b += double(weight * power5(std::max(0.0f, 1 - half.dot(to_light))));
    }
    nodes_[i] = {float(a / num_samples), float(b / num_samples)};
  }
  nodes_[num_nodes] = nodes_[num_nodes - 1];
}

GlossyAlbedo::Value GlossyAlbedo::at(float cosine) const {
  const float position = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (num_nodes - 1);
  const int i = int(position);
  const float t = position - float(i);
  return {nodes_[i].a + t * (nodes_[i + 1].a - nodes_[i].a), nodes_[i].b + t * (nodes_[i + 1].b - nodes_[i].b)};
}

BsdfLook make_bsdf_look(const Look& look, const std::string& where) {
  check_unit_range(look.roughness, where, "roughness");
  check_unit_range(look.metallic, where, "metallic");
  check_unit_range(look.clearcoat, where, "clearcoat");
  check_unit_range(look.clearcoat_roughness, where, "clearcoat_roughness");
  if (!(look.ior >= 1 && look.ior < 10)) {
    throw Error(ExitCode::bad_data, {.where = where + ": ior",
                                     .what = "must be at least 1",
                                     .value = std::to_string(look.ior),
                                     .remedy = "1.5 is glass and most plastics"});
  }
  BsdfLook result{.alpha = alpha_of(look.roughness),
                  .f0 = reflectance_at_normal(look.ior),
                  .f90 = std::min(1.0f, 50 * reflectance_at_normal(look.ior)),  // none where the layer is none
                  .metallic = look.metallic,
                  .coat = look.clearcoat,
                  .coat_alpha = alpha_of(look.clearcoat_roughness),
                  .albedo = {},
                  .coat_albedo = {}};
  result.albedo = GlossyAlbedo(result.alpha);
  if (result.coat > 0) result.coat_albedo = GlossyAlbedo(result.coat_alpha);
  return result;
}

Bsdf make_bsdf(const BsdfLook& look, const Vector3f& base_color, const Vector3f& to_viewer) {
  Bsdf bsdf;
  bsdf.to_viewer = to_viewer;
  bsdf.glossy_lobe = make_lobe(look.alpha, to_viewer.z());
  const GlossyAlbedo::Value e = look.albedo.at(to_viewer.z());
  // the coat comes first, the rest shares what it lets through
  float coat_albedo = 0;
  if (look.coat > 0) {
    constexpr float coat_f0 = 0.04f;
    const GlossyAlbedo::Value c = look.coat_albedo.at(to_viewer.z());
    bsdf.coat_lobe = make_lobe(look.coat_alpha, to_viewer.z());
    bsdf.coat = look.coat * compensation(coat_f0, c.a);
    coat_albedo = bsdf.coat * (coat_f0 * c.a + (1 - coat_f0) * c.b);
  }
  const float below_coat = 1 - coat_albedo;
  // dielectric layer over the diffuse base
  const float dielectric = below_coat * (1 - look.metallic) * compensation(look.f0, e.a);
  bsdf.glossy_a.setConstant(dielectric * look.f0);
  bsdf.glossy_b.setConstant(dielectric * (look.f90 - look.f0));
  const float dielectric_albedo = compensation(look.f0, e.a) * (look.f0 * e.a + (look.f90 - look.f0) * e.b);
  bsdf.diffuse = below_coat * (1 - look.metallic) * (1 - dielectric_albedo) * base_color;
  // metal
  if (look.metallic > 0) {
    for (int c = 0; c < 3; ++c) {
      const float metal = below_coat * look.metallic * compensation(base_color[c], e.a);
      bsdf.glossy_a[c] += metal * base_color[c];
      bsdf.glossy_b[c] += metal * (1 - base_color[c]);
    }
  }
  // lobes are chosen by the light they send to the viewer; none so rarely that its bright directions become sparks
  const Vector3f glossy_albedo = e.a * bsdf.glossy_a + e.b * bsdf.glossy_b;
  bsdf.albedo = bsdf.diffuse + glossy_albedo + Vector3f::Constant(coat_albedo);
  const float diffuse = bsdf.diffuse.sum(), least = 0.18f * diffuse;
  const float glossy = look.f90 > 0 || look.metallic > 0 ? std::max(glossy_albedo.sum(), least) : 0.0f;
  const float coat = look.coat > 0 ? std::max(3 * coat_albedo, least) : 0.0f;
  const float total = diffuse + glossy + coat;
  bsdf.choose_diffuse = total > 0 ? diffuse / total : 1;
  bsdf.choose_glossy = coat > 0 ? glossy / total : 1 - bsdf.choose_diffuse;
  return bsdf;
}

BsdfValue evaluate_bsdf(const Bsdf& bsdf, const Vector3f& to_light) {
  BsdfValue result;
  if (!(to_light.z() > 0)) return result;
  const float cosine_over_pi = to_light.z() * inverse_pi;
  result.value = bsdf.diffuse * cosine_over_pi;
  result.density = bsdf.choose_diffuse * cosine_over_pi;
  const LobeValue glossy = evaluate_lobe(bsdf.glossy_lobe, bsdf.to_viewer, to_light);
  result.value += glossy.scale * (bsdf.glossy_a + glossy.fresnel * bsdf.glossy_b);
  result.density += bsdf.choose_glossy * glossy.density;
  if (bsdf.coat > 0) {
    const LobeValue coat = evaluate_lobe(bsdf.coat_lobe, bsdf.to_viewer, to_light);
    result.value.array() += coat.scale * bsdf.coat * (0.04f + 0.96f * coat.fresnel);
    result.density += (1 - bsdf.choose_diffuse - bsdf.choose_glossy) * coat.density;
  }
  return result;
}

BsdfSample sample_bsdf(const Bsdf& bsdf, const Vector2f& u) {
  BsdfSample sample;
  // the first number chooses the lobe and is stretched to serve again
  if (u.x() < bsdf.choose_diffuse) {
    sample.to_light = cosine_hemisphere({u.x() / bsdf.choose_diffuse, u.y()});
  } else {
    const float rest = u.x() - bsdf.choose_diffuse, share = 1 - bsdf.choose_diffuse;
    const bool glossy = !(bsdf.coat > 0) || rest < bsdf.choose_glossy;
    const float stretched = !(bsdf.coat > 0) ? rest / share
                            : glossy         ? rest / bsdf.choose_glossy
                                             : (rest - bsdf.choose_glossy) / (share - bsdf.choose_glossy);
    const Vector2f again(std::min(stretched, 0.99999994f), u.y());
    const Vector3f half =
        sample_visible_normal(glossy ? bsdf.glossy_lobe.alpha : bsdf.coat_lobe.alpha, bsdf.to_viewer, again);
    sample.to_light = reflect(bsdf.to_viewer, half);
    if (!(sample.to_light.z() > 1e-6f)) return sample;
  }
  const BsdfValue value = evaluate_bsdf(bsdf, sample.to_light);
  sample.density = value.density;
  if (value.density > 0) sample.weight = value.value / value.density;
  return sample;
}

}  // namespace umax
