// Clear-sky daylight from the sun's place and the air's turbidity [Preetham, Shirley, Smits 1999, "A practical analytic
// model for daylight"]: sky dome and sun as linear Rec. 709.
#pragma once

#include "render/scene/render_scene.h"

namespace umax {

/// Radiance is in units in which a white diffuse floor under a clear noon sky is about 1 (one unit: 32 kcd/m^2).
struct Daylight {
  explicit Daylight(const DaylightSky& sky);

  /// Dome only, without the sun; below the horizon the light that a grey earth gives back.
  Vector3f dome(const Vector3f& direction) const;

  Vector3f sun_direction;          // unit
  float sun_cosine = 1;            // of the disc's angular radius
  float sun_solid_angle = 0;       // [sr]
  Vector3f sun_radiance{0, 0, 0};  // of the disc; its irradiance does not depend on its size

 private:
  struct Perez {
    float a, b, c, d, e;
    float at(float cos_zenith, float angle, float cos_angle) const;
  };
  Vector3f sky(const Vector3f& direction) const;
  Perez luminance_, x_, y_;
  float zenith_luminance_ = 0, zenith_x_ = 0, zenith_y_ = 0;  // divided by Perez' function at the zenith
  float scale_ = 1;
  Vector3f earth_{0, 0, 0};
};

}  // namespace umax
