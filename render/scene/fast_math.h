// Short polynomials for angles in the path tracer's inner loop: the same bits on every machine, unlike the C library's.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace umax {

struct SinCos {
  float sine, cosine;
};

/// Sine and cosine of an angle within [-pi/4, pi/4], to 2e-7.
inline SinCos sin_cos_quarter(float angle) {
  const float s = angle * angle;
  const float sine = angle * (1 + s * (-1.6666655e-1f + s * (8.3321609e-3f - s * 1.9515296e-4f)));
  const float cosine = 1 + s * (-0.5f + s * (4.1666646e-2f + s * (-1.3887316e-3f + s * 2.4433157e-5f)));
  return {sine, cosine};
}

/// Sine and cosine of any moderate angle (|angle| < 1e4), without branches.
inline SinCos sin_cos(float angle) {
  const float turns = std::nearbyint(angle * 0.63661977f);
  const int quadrant = int(turns);
  const SinCos q = sin_cos_quarter((angle - turns * 1.57079637f) + turns * 4.37113883e-8f);
  const bool odd = (quadrant & 1) != 0;
  const float sine = odd ? q.cosine : q.sine, cosine = odd ? q.sine : q.cosine;
  return {(quadrant & 2) != 0 ? -sine : sine, ((quadrant + 1) & 2) != 0 ? -cosine : cosine};
}

/// Angle of the point (x, y) in [-pi, pi], to 1e-6; 0 at the origin. Without branches.
inline float fast_atan2(float y, float x) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float larger = ax > ay ? ax : ay, smaller = ax > ay ? ay : ax;
  const bool at_origin = !(larger > 0);
  const float t = smaller / (at_origin ? 1.0f : larger), s = t * t;
  // odd polynomial for the arc tangent on [0, 1], after Abramowitz and Stegun 4.4.49
  float angle =
      t *
      (1 +
       s * (-0.3333314528f +
            s * (0.1999355085f +
                 s * (-0.1420889944f +
                      s * (0.1065626393f +
                           s * (-0.0752896400f + s * (0.0429096138f + s * (-0.0161657367f + s * 0.0028662257f))))))));
  angle = ay > ax ? 1.57079633f - angle : angle;
  angle = x < 0 ? 3.14159265f - angle : angle;
  angle = y < 0 ? -angle : angle;
  return at_origin ? 0.0f : angle;
}

}  // namespace umax
