#include "render/trace/bsdf.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "render/scene/sampling.h"

namespace umax {
namespace {

Vector3f vector_of(const Direction& d) {
  return {d.x, d.y, d.z};
}

void check_unit_range(float value, const std::string& where, const char* key) {
  if (value >= 0 && value <= 1) return;
  throw Error(Fault::bad_data, {.where = where + ": " + key,
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

}  // namespace

GlossyAlbedo::GlossyAlbedo(float alpha) {
  constexpr int num_samples = 128;
  const SampleSequence sequence(num_samples, 7);
  for (int i = 0; i < num_nodes; ++i) {
    // nodes are denser towards grazing angles
    const float cosine = std::max(float(i * i) / float((num_nodes - 1) * (num_nodes - 1)), 1e-5f);
    const Direction viewer{std::sqrt(std::max(0.0f, 1 - cosine * cosine)), 0, cosine};
    const float root_viewer = bsdf_core::smith_root(alpha, cosine);
    double a = 0, b = 0;
    for (int s = 0; s < num_samples; ++s) {
      const Vector2f u = sequence.point(unsigned(s), i, 0);
      const Direction light = bsdf_core::mirrored_direction(alpha, viewer, u.x(), u.y());
      if (light.z <= 0) continue;
      // what is left of G2 / G1 after sampling visible normals
      const float root_light = bsdf_core::smith_root(alpha, light.z);
      const float weight = light.z * (cosine + root_viewer) / (light.z * root_viewer + cosine * root_light);
      const Vector3f half = vector_of(viewer) + vector_of(light);
      a += double(weight);
      b += double(weight * bsdf_core::power5(std::max(0.0f, 1 - 0.5f * half.norm())));
    }
    nodes_[i] = {float(a / num_samples), float(b / num_samples)};
  }
  nodes_[num_nodes] = nodes_[num_nodes - 1];
}

BsdfLook make_bsdf_look(const Look& look, const std::string& where) {
  check_unit_range(look.roughness, where, "roughness");
  check_unit_range(look.metallic, where, "metallic");
  check_unit_range(look.clearcoat, where, "clearcoat");
  check_unit_range(look.clearcoat_roughness, where, "clearcoat_roughness");
  if (!(look.ior >= 1 && look.ior < 10)) {
    throw Error(Fault::bad_data, {.where = where + ": ior",
                                  .what = "must be at least 1",
                                  .value = std::to_string(look.ior),
                                  .remedy = "1.5 is glass and most plastics"});
  }
  const float f0 = reflectance_at_normal(look.ior);
  BsdfLook result{.numbers = {.alpha = alpha_of(look.roughness),
                              .f0 = f0,
                              .f90 = std::min(1.0f, 50 * f0),  // none where the layer is none
                              .metallic = look.metallic,
                              .coat = look.clearcoat,
                              .coat_alpha = alpha_of(look.clearcoat_roughness)},
                  .albedo = {},
                  .coat_albedo = {}};
  result.albedo = GlossyAlbedo(result.numbers.alpha);
  if (look.clearcoat > 0) result.coat_albedo = GlossyAlbedo(result.numbers.coat_alpha);
  return result;
}

Bsdf make_bsdf(const BsdfLook& look, const Vector3f& base_color, const Vector3f& to_viewer) {
  return bsdf_core::make_surface(look.numbers, look.layers(to_viewer.z()),
                                 {base_color.x(), base_color.y(), base_color.z()}, direction_of(to_viewer));
}

BsdfValue evaluate_bsdf(const Bsdf& bsdf, const Vector3f& to_light) {
  const bsdf_core::Value value = bsdf_core::evaluate(bsdf, direction_of(to_light));
  return {.value = {value.value.r, value.value.g, value.value.b}, .density = value.density};
}

BsdfSample sample_bsdf(const Bsdf& bsdf, const Vector2f& u) {
  const bsdf_core::LobeChoice choice = bsdf_core::choose_lobe(bsdf, u.x());
  const Direction cosine = bsdf_core::cosine_direction(choice.again, u.y());
  const Direction mirrored = bsdf_core::mirrored_direction(choice.alpha, bsdf.viewer, choice.again, u.y());
  BsdfSample sample;
  sample.to_light = vector_of(bsdf_core::select_direction(choice, cosine, mirrored));
  const BsdfValue value = evaluate_bsdf(bsdf, sample.to_light);
  sample.density = value.density;
  if (value.density > 0) sample.weight = value.value / value.density;
  return sample;
}

}  // namespace umax
