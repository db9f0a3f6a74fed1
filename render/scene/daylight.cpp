#include "render/scene/daylight.h"

#include <algorithm>
#include <cmath>

namespace umax {
namespace {

constexpr float pi = 3.14159265f;
constexpr float kilocandela_per_unit = 32;

Vector3f rgb_from_chromaticity(float luminance, float x, float y) {
  const float X = x / y * luminance, Z = (1 - x - y) / y * luminance;
  return {3.2404542f * X - 1.5371385f * luminance - 0.4985314f * Z,
          -0.9692660f * X + 1.8760108f * luminance + 0.0415560f * Z,
          0.0556434f * X - 0.2040259f * luminance + 1.0572252f * Z};
}

// share of sunlight that passes the air, at the wavelengths that stand for red, green and blue (appendix of the paper)
Vector3f sun_transmittance(float zenith_angle, float turbidity) {
  const float degrees = zenith_angle * 180 / pi;
  const float air_mass = 1 / (std::max(std::cos(zenith_angle), 0.0f) + 0.15f * std::pow(93.885f - degrees, -1.253f));
  const float aerosol = 0.04608f * turbidity - 0.04586f;
  const float wavelength[3] = {0.61f, 0.55f, 0.465f};  // [micrometre]
  const float ozone[3] = {0.12f, 0.085f, 0.01f};       // [1/cm]
  Vector3f result;
  for (int c = 0; c < 3; ++c) {
    const float depth =
        0.008735f * std::pow(wavelength[c], -4.08f) + aerosol * std::pow(wavelength[c], -1.3f) + 0.35f * ozone[c];
    result[c] = std::exp(-depth * air_mass);
  }
  return result;
}

float zenith_chromaticity(float turbidity, float t, const float (&m)[3][4]) {
  const auto cubic = [&](const float(&k)[4]) { return ((k[0] * t + k[1]) * t + k[2]) * t + k[3]; };
  return turbidity * turbidity * cubic(m[0]) + turbidity * cubic(m[1]) + cubic(m[2]);
}

}  // namespace

float Daylight::Perez::at(float cos_zenith, float angle, float cos_angle) const {
  return (1 + a * std::exp(b / cos_zenith)) * (1 + c * std::exp(d * angle) + e * cos_angle * cos_angle);
}

Daylight::Daylight(const DaylightSky& sky) : sun_direction(sky.sun_direction.normalized()) {
  const float T = std::clamp(sky.turbidity, 1.8f, 10.0f);
  // the model ends at the horizon; a sun below it fades out within 6 degrees
  const float elevation = std::asin(std::clamp(sun_direction.y(), -1.0f, 1.0f));
  const float theta = std::min(pi / 2 - elevation, 1.535f);
  const float twilight = std::clamp(1 + std::min(elevation, 0.0f) / (6 * pi / 180), 0.0f, 1.0f);
  luminance_ = {0.1787f * T - 1.4630f, -0.3554f * T + 0.4275f, -0.0227f * T + 5.3251f, 0.1206f * T - 2.5771f,
                -0.0670f * T + 0.3703f};
  x_ = {-0.0193f * T - 0.2592f, -0.0665f * T + 0.0008f, -0.0004f * T + 0.2125f, -0.0641f * T - 0.8989f,
        -0.0033f * T + 0.0452f};
  y_ = {-0.0167f * T - 0.2608f, -0.0950f * T + 0.0092f, -0.0079f * T + 0.2102f, -0.0441f * T - 1.6537f,
        -0.0109f * T + 0.0529f};
  constexpr float zenith_x[3][4] = {{0.00166f, -0.00375f, 0.00209f, 0},
                                    {-0.02903f, 0.06377f, -0.03202f, 0.00394f},
                                    {0.11693f, -0.21196f, 0.06052f, 0.25886f}};
  constexpr float zenith_y[3][4] = {{0.00275f, -0.00610f, 0.00317f, 0},
                                    {-0.04214f, 0.08970f, -0.04153f, 0.00516f},
                                    {0.15346f, -0.26756f, 0.06670f, 0.26688f}};
  const float chi = (4.0f / 9 - T / 120) * (pi - 2 * theta);
  const float zenith = std::max((4.0453f * T - 4.9710f) * std::tan(chi) - 0.2155f * T + 2.4192f, 0.05f);  // [kcd/m^2]
  const float cos_theta = std::cos(theta);
  zenith_luminance_ = zenith / luminance_.at(1, theta, cos_theta);
  zenith_x_ = zenith_chromaticity(T, theta, zenith_x) / x_.at(1, theta, cos_theta);
  zenith_y_ = zenith_chromaticity(T, theta, zenith_y) / y_.at(1, theta, cos_theta);
  scale_ = sky.intensity * twilight / kilocandela_per_unit;

  // sun: 128 klx above the air, spread over the disc that was asked for
  const float radius = std::clamp(sky.sun_size_degrees, 0.05f, 60.0f) * pi / 360;
  sun_cosine = std::cos(radius);
  sun_solid_angle = 4 * pi * std::pow(std::sin(radius / 2), 2.0f);
  const Vector3f above_air = 128 * Vector3f(1.05f, 0.99f, 0.95f);
  if (elevation > 0) sun_radiance = scale_ / sun_solid_angle * above_air.cwiseProduct(sun_transmittance(theta, T));

  // what a grey earth sends back: albedo times irradiance over pi, from a coarse sum over the dome
  Vector3f irradiance = sun_radiance * sun_solid_angle * std::max(sun_direction.y(), 0.0f);
  constexpr int rings = 12, sectors = 24;
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const float y = std::sqrt((float(i) + 0.5f) / rings), r = std::sqrt(1 - y * y), phi = 2 * pi * float(j) / sectors;
      irradiance += pi / (rings * sectors) * this->sky({r * std::cos(phi), y, r * std::sin(phi)});
    }
  }
  earth_ = 0.25f / pi * irradiance;
}

Vector3f Daylight::sky(const Vector3f& direction) const {
  const float cos_zenith = std::max(direction.y(), 0.01f);
  const float cos_angle = std::clamp(direction.dot(sun_direction), -1.0f, 1.0f);
  const float angle = std::acos(cos_angle);
  const float luminance = zenith_luminance_ * luminance_.at(cos_zenith, angle, cos_angle);
  const float x = zenith_x_ * x_.at(cos_zenith, angle, cos_angle);
  const float y = zenith_y_ * y_.at(cos_zenith, angle, cos_angle);
  return (scale_ * rgb_from_chromaticity(std::max(luminance, 0.0f), x, std::max(y, 0.05f))).cwiseMax(0.0f);
}

Vector3f Daylight::dome(const Vector3f& direction) const {
  if (direction.y() >= 0) return sky(direction);
  // haze hides the edge of the earth
  const float t = std::min(-direction.y() / 0.35f, 1.0f), blend = t * t * (3 - 2 * t);
  return (1 - blend) * sky({direction.x(), 0, direction.z()}) + blend * earth_;
}

}  // namespace umax
