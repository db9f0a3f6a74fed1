// How surfaces scatter light: a diffuse base under a glossy dielectric or metallic layer, and a clear coat.
//
//   f = f_coat + (1 - E_coat(o)) [ f_glossy + (1 - metallic) (1 - E_dielectric(o)) base / pi ]
//
// f_glossy, f_coat: GGX microfacets with height-correlated Smith shadowing [Heitz 2014], Schlick's Fresnel term,
// roughness as alpha = roughness^2, sampled by visible normals [Dupuy, Benyoub 2023, "Sampling visible GGX normals with
// spherical caps"], and scaled for the light that bounces among the facets [Turquin 2019] by
//   1 + F0 (1 - E) / E
// E(o): the layer's reflectance for light from direction o;  F0: its Fresnel reflectance head-on;  all f [1/sr]
// Whatever a layer reflects is taken from what is below it: a white body in a white furnace is white for every look.
// Directions are local: z along the shading normal, both pointing away from the surface.
#pragma once

#include <array>
#include <string>

#include "render/scene/render_scene.h"
#include "render/trace/bsdf_core.h"

namespace umax {

/// Reflectance of a GGX layer over the cosine of the view direction, for Schlick's Fresnel term: E = F0 a + (1 - F0) b.
class GlossyAlbedo {
 public:
  GlossyAlbedo() = default;
  explicit GlossyAlbedo(float alpha);
  struct Value {
    float a = 1, b = 0;
  };
  Value at(float cosine) const {
    const float position = std::sqrt(cosine < 1 ? cosine : 1.0f) * (num_nodes - 1);
    const int i = int(position);
    const float t = position - float(i);
    return {nodes_[i].a + t * (nodes_[i + 1].a - nodes_[i].a), nodes_[i].b + t * (nodes_[i + 1].b - nodes_[i].b)};
  }

 private:
  static constexpr int num_nodes = 64;
  std::array<Value, num_nodes + 1> nodes_{};
};

/// A look with its tables: one per object, made once a picture.
struct BsdfLook {
  bsdf_core::LookNumbers numbers;
  GlossyAlbedo albedo, coat_albedo;

  /// Reflectances of its layers for light from a direction of this cosine.
  bsdf_core::LayerAlbedo layers(float cosine) const {
    const GlossyAlbedo::Value glossy = albedo.at(cosine);
    const GlossyAlbedo::Value coat = numbers.coat > 0 ? coat_albedo.at(cosine) : GlossyAlbedo::Value{};
    return {.a = glossy.a, .b = glossy.b, .coat_a = coat.a, .coat_b = coat.b};
  }
};
/// Throws Error 65 for values outside their range; where: the object's name, for the message.
BsdfLook make_bsdf_look(const Look& look, const std::string& where);

/// The look at one point, seen from one direction (unit, z > 0).
using Bsdf = bsdf_core::Surface;
Bsdf make_bsdf(const BsdfLook& look, const Vector3f& base_color, const Vector3f& to_viewer);

struct BsdfValue {
  Vector3f value{0, 0, 0};  // f cos [1/sr]
  float density = 0;        // of sample_bsdf() [1/sr]
};
BsdfValue evaluate_bsdf(const Bsdf& bsdf, const Vector3f& to_light);

struct BsdfSample {
  Vector3f to_light{0, 0, 1};
  Vector3f weight{0, 0, 0};  // f cos / density; zero when the sample is lost below the surface
  float density = 0;
};
BsdfSample sample_bsdf(const Bsdf& bsdf, const Vector2f& u);

}  // namespace umax
