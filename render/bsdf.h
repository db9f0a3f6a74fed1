// How surfaces scatter light: a diffuse base under a glossy dielectric or metallic layer, and a clear coat.
//
//   f = f_coat + (1 - E_coat(o)) [ f_glossy + (1 - metallic) (1 - E_dielectric(o)) base / pi ]
//   f_glossy, f_coat: GGX microfacets with height-correlated Smith shadowing [Heitz 2014], Schlick's Fresnel term,
//   roughness as alpha = roughness^2, sampled by visible normals [Dupuy, Benyoub 2023, "Sampling visible GGX normals
//   with spherical caps"], and scaled by 1 + F0 (1 - E) / E for the light that bounces among the facets [Turquin 2019].
//   E(o): the layer's reflectance for light from direction o. Whatever a layer reflects is taken from what is below it:
//   a white body in a white furnace is white for every look.
// Directions are local: z along the shading normal, both pointing away from the surface.
#pragma once

#include <array>

#include "render/render_scene.h"

namespace umax {

/// Reflectance of a GGX layer over the cosine of the view direction, for Schlick's Fresnel term: E = F0 a + (1 - F0) b.
class GlossyAlbedo {
 public:
  GlossyAlbedo() = default;
  explicit GlossyAlbedo(float alpha);
  struct Value {
    float a, b;
  };
  Value at(float cosine) const;

 private:
  static constexpr int num_nodes = 64;
  std::array<Value, num_nodes + 1> nodes_{};
};

/// A look with its tables: one per object, made once a picture.
struct BsdfLook {
  float alpha = 0.25f, f0 = 0.04f, f90 = 1, metallic = 0;
  float coat = 0, coat_alpha = 1e-3f;
  GlossyAlbedo albedo, coat_albedo;
};
/// Throws Error 65 for values outside their range; where: the object's name, for the message.
BsdfLook make_bsdf_look(const Look& look, const std::string& where);

/// The look at one point, seen from one direction.
struct Bsdf {
  struct Lobe {
    float alpha = 0.25f;
    float root_viewer = 1, density_scale = 0.25f;  // of Smith's shadowing, for the view direction
  };
  Vector3f to_viewer;           // local, unit, z > 0
  Vector3f diffuse;             // reflectance of the base
  Vector3f glossy_a, glossy_b;  // Fresnel term glossy_a + glossy_b (1 - c)^5, all scales included
  float coat = 0;               // scale of the coat's lobe
  Lobe glossy_lobe, coat_lobe;
  float choose_diffuse = 1, choose_glossy = 0;  // probabilities; the rest goes to the coat
  Vector3f albedo;                              // reflectance in all, towards the viewer
};
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
