// Light inside of closed bodies, on its way until it leaves them again.
//
// Clear matter (transmission): light is bent where it enters and leaves, in microfacets of the look's roughness, or
// thrown back inside, as Fresnel's equations and Snell's law say; on the way T(d) = exp(-s d), s = -ln(color) / depth.
//
// Cloudy matter (subsurface): light wanders. It goes straight for a distance of density exp(-t / r) / r, turns into any
// direction alike, and at each turn the share 1 - a is absorbed; r is the radius, and a is such that a half space of the
// matter, evenly lit, sends back the look's colour A [Kulla, Conty 2017, "Revisiting physically based shading at
// Imageworks"; after van de Hulst's fit]:
//   a = 1 - q^2,   q = 4.09712 + 4.20863 A - sqrt(9.59217 + 41.6808 A + 17.7126 A^2)
// Each distance is drawn for one of the three colours by chance, and weighed as if drawn for all three [Chiang, Kutz,
// Burley 2016, "Practical and controllable subsurface scattering for production path tracing"].
//
// What gets below the surface, and is not absorbed, gets out again: in a white furnace white matter is white.
#pragma once

#include <string>

#include "render/scene/sampling.h"
#include "render/trace/ray_scene.h"

namespace umax {

/// What a look says of the inside of bodies: one per object, made once a picture.
struct Matter {
  float transmission = 0, subsurface = 0;  // shares of the base: of all of it, of the rest
  float depth = 0.1f;                      // [m]
  Vector3f radius{0.01f, 0.01f, 0.01f};    // [m]
  float ior = 1.5f, alpha = 0.25f;
  bool is_smooth = false;  // what lies behind is seen

  bool lets_light_in() const { return transmission > 0 || subsurface > 0; }
};
/// Throws Error 65 for values outside their range; where: the object's name, for the message.
Matter make_matter(const Look& look, const std::string& where);

/// Numbers by chance for what takes too many of them to be drawn from the sequence: the same for the same path.
class PathRandom {
 public:
  PathRandom(std::uint32_t a, std::uint32_t b, std::uint32_t c) : state_(hash_bits(a ^ hash_bits(b ^ hash_bits(c)))) {}
  /// In [0, 1).
  float next() {
    state_ += 0x9e3779b9u;
    return float(hash_bits(state_) >> 8) * 0x1p-24f;
  }

 private:
  std::uint32_t state_;
};

/// Light that goes through clear matter, towards what it meets next: outside, or of another object inside.
struct Passage {
  Ray ray;
  Vector3f weight{1, 1, 1};
};
/// Where `incoming` meets the boundary: from outside light is let in, from inside it may be thrown back. first: chooses
/// the first microfacet.
Passage pass_through(const RayScene& rays, const Matter& matter, const Vector3f& color, const Ray& incoming,
                     const Hit& hit, const Vector2f& first, PathRandom& random);

/// Light that wanders in cloudy matter, to where it gets out.
struct Walk {
  Hit exit;
  Vector3f outwards{0, 1, 0};  // any direction that leaves the surface there
  Vector3f weight{1, 1, 1};    // 0: absorbed
};
/// From where `incoming` meets the boundary from outside. first: chooses the first direction.
Walk wander(const RayScene& rays, const Matter& matter, const Vector3f& color, const Ray& incoming, const Hit& hit,
            const Vector2f& first, PathRandom& random);

/// a, of the look's colour, and that of other colours than grey.
Vector3f scattered_share(const Vector3f& color);

}  // namespace umax
