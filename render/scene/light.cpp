// Rectangles are sampled uniformly in the solid angle they fill [Urena, Fajardo, King 2013].
#include "render/scene/light.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/srgb.h"
#include "render/scene/fast_math.h"

namespace umax {
namespace {

constexpr float pi = 3.14159265f;

// below this many steradians choosing by area is as good, much cheaper, and loses no digits
constexpr float least_solid_angle = 0.25f;

// A rectangle as seen from a point: bounds of its local coordinates, angles between its edges' planes.
struct SphericalRectangle {
  float x0, x1, y0, y1, z0;  // local coordinates of the edges; z0 < 0
  float b0, b1, k;           // z components of two edge normals; angle to subtract
  float solid_angle;
};

SphericalRectangle project(float x0, float x1, float y0, float y1, float distance) {
  SphericalRectangle s{
      .x0 = x0, .x1 = x1, .y0 = y0, .y1 = y1, .z0 = -distance, .b0 = 0, .b1 = 0, .k = 0, .solid_angle = 0};
  // z components of the unit normals of the four planes through the eye and an edge
  const float z0 = s.z0;
  const float n0z = -y0 / std::sqrt(z0 * z0 + y0 * y0), n2z = y1 / std::sqrt(z0 * z0 + y1 * y1);
  const float n1z = x1 / std::sqrt(z0 * z0 + x1 * x1), n3z = -x0 / std::sqrt(z0 * z0 + x0 * x0);
  // corner angles are acos(-n0 n1), ...; two of them are added as rotations
  const auto add_corners = [](float c, float d) {
    const float sc = std::sqrt(std::max(0.0f, 1 - c * c)), sd = std::sqrt(std::max(0.0f, 1 - d * d));
    const float angle = fast_atan2(sc * d + c * sd, c * d - sc * sd);
    return angle < 0 ? angle + 2 * pi : angle;
  };
  const float g01 = add_corners(-n0z * n1z, -n1z * n2z), g23 = add_corners(-n2z * n3z, -n3z * n0z);
  s.b0 = n0z;
  s.b1 = n2z;
  s.k = 2 * pi - g23;
  s.solid_angle = g01 - s.k;
  return s;
}

// local x and y of the point that splits the solid angle as u does
Vector2f pick(const SphericalRectangle& s, const Vector2f& u) {
  const SinCos a = sin_cos(u.x() * s.solid_angle + s.k);
  const float f = (a.cosine * s.b0 - s.b1) / a.sine;
  const float c = std::clamp(std::copysign(1.0f, f) / std::sqrt(f * f + s.b0 * s.b0), -1.0f, 1.0f);
  const float x = std::clamp(-(c * s.z0) / std::max(std::sqrt(1 - c * c), 1e-7f), s.x0, s.x1);
  const float d = std::sqrt(x * x + s.z0 * s.z0);
  const float h0 = s.y0 / std::sqrt(d * d + s.y0 * s.y0), h1 = s.y1 / std::sqrt(d * d + s.y1 * s.y1);
  const float h = h0 + u.y() * (h1 - h0), h2 = h * h;
  const float y = h2 < 1 - 1e-6f ? h * d / std::sqrt(1 - h2) : s.y1;
  return {x, std::clamp(y, s.y0, s.y1)};
}

}  // namespace

RectangleLights::RectangleLights(const std::vector<AreaLight>& lights) {
  for (const AreaLight& light : lights) {
    Rectangle r;
    r.corner = light.corner;
    r.length_u = light.edge_u.norm();
    r.length_v = light.edge_v.norm();
    r.area = light.edge_u.cross(light.edge_v).norm();
    if (!(r.area > 0) || !light.corner.allFinite() || !std::isfinite(r.area) || !light.radiance.allFinite()) {
      throw Error(Fault::bad_data, {.where = "light",
                                    .what = "has no area, or values that are not finite",
                                    .value = "area " + std::to_string(r.area) + " m^2",
                                    .remedy = "give it a size above 0"});
    }
    r.axis_u = light.edge_u / r.length_u;
    r.axis_v = light.edge_v / r.length_v;
    r.normal = light.edge_u.cross(light.edge_v) / r.area;
    r.right_angled = std::abs(r.axis_u.dot(r.axis_v)) < 1e-4f;
    r.radiance = light.radiance;
    r.power = r.area * luminance(r.radiance.x(), r.radiance.y(), r.radiance.z());
    r.visible = light.visible;
    if (r.power > 0) lights_.push_back(r);
  }
}

float RectangleLights::guess(const Rectangle& light, const Vector3f& from) {
  const Vector3f middle = light.corner + 0.5f * light.length_u * light.axis_u + 0.5f * light.length_v * light.axis_v;
  const bool bright_side = (from - light.corner).dot(light.normal) > 0;
  return bright_side ? light.power / std::max((middle - from).squaredNorm(), light.area) : 0.0f;
}

float RectangleLights::total_guess(const Vector3f& from) const {
  float total = 0;
  for (const Rectangle& light : lights_) total += guess(light, from);
  return total;
}

LightSample RectangleLights::sample(const Vector3f& from, const Vector2f& u_in) const {
  LightSample sample;
  Vector2f u = u_in;
  // choose a light; the number that chose is stretched to serve again
  std::size_t chosen = 0;
  float chance = 1;
  if (lights_.size() > 1) {
    const float total = total_guess(from);
    if (!(total > 0)) return sample;
    float below = 0, g = guess(lights_[0], from);
    while (chosen + 1 < lights_.size() && u.x() * total >= below + g) {
      below += g;
      g = guess(lights_[++chosen], from);
    }
    if (!(g > 0)) return sample;
    chance = g / total;
    u.x() = std::clamp((u.x() * total - below) / g, 0.0f, 0.99999994f);
  }
  const Rectangle& light = lights_[chosen];
  const Vector3f to_corner = light.corner - from;
  const float height = -to_corner.dot(light.normal);
  if (!(height > 1e-6f)) return sample;
  // by solid angle where that is large, else by area
  Vector3f to_point;
  float density = 0;
  const float x0 = to_corner.dot(light.axis_u), y0 = to_corner.dot(light.axis_v);
  const float middle2 =
      (to_corner + 0.5f * light.length_u * light.axis_u + 0.5f * light.length_v * light.axis_v).squaredNorm();
  if (light.right_angled && light.area * height > least_solid_angle * middle2 * std::sqrt(middle2)) {
    const SphericalRectangle s = project(x0, x0 + light.length_u, y0, y0 + light.length_v, height);
    const Vector2f p = pick(s, u);
    to_point = p.x() * light.axis_u + p.y() * light.axis_v - height * light.normal;
    density = 1 / s.solid_angle;
  } else {
    to_point = to_corner + u.x() * light.length_u * light.axis_u + u.y() * light.length_v * light.axis_v;
  }
  const float distance2 = to_point.squaredNorm();
  sample.distance = std::sqrt(distance2);
  sample.direction = to_point / sample.distance;
  if (density == 0) density = distance2 * sample.distance / (height * light.area);
  sample.density = chance * density;
  sample.radiance = light.radiance;
  return sample;
}

RectangleLights::Met RectangleLights::meet(const Vector3f& origin, const Vector3f& direction, float max_distance,
                                           bool from_camera) const {
  Met met{.light = -1, .distance = max_distance};
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const Rectangle& light = lights_[i];
    if (from_camera && !light.visible) continue;
    const float approach = -direction.dot(light.normal);
    if (!(approach > 0)) continue;
    const Vector3f from_corner = origin - light.corner;
    const float distance = from_corner.dot(light.normal) / approach;
    if (!(distance > 0 && distance < met.distance)) continue;
    const Vector3f p = from_corner + distance * direction;
    // coordinates along both edges, also where they are not at right angles
    const float skew = light.axis_u.dot(light.axis_v), pu = p.dot(light.axis_u), pv = p.dot(light.axis_v);
    const float scale = 1 / (1 - skew * skew), u = (pu - skew * pv) * scale, v = (pv - skew * pu) * scale;
    if (u >= 0 && u <= light.length_u && v >= 0 && v <= light.length_v) met = {.light = int(i), .distance = distance};
  }
  return met;
}

float RectangleLights::density(const Met& met, const Vector3f& from, const Vector3f& direction) const {
  const Rectangle& light = lights_[met.light];
  const float chance = lights_.size() > 1 ? guess(light, from) / total_guess(from) : 1;
  const Vector3f to_corner = light.corner - from;
  const float height = -to_corner.dot(light.normal);
  const float middle2 =
      (to_corner + 0.5f * light.length_u * light.axis_u + 0.5f * light.length_v * light.axis_v).squaredNorm();
  if (light.right_angled && light.area * height > least_solid_angle * middle2 * std::sqrt(middle2)) {
    const float x0 = to_corner.dot(light.axis_u), y0 = to_corner.dot(light.axis_v);
    return chance / project(x0, x0 + light.length_u, y0, y0 + light.length_v, height).solid_angle;
  }
  return chance * met.distance * met.distance / (-direction.dot(light.normal) * light.area);
}

}  // namespace umax
