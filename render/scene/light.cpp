// Rectangles are sampled uniformly in the solid angle they fill [Urena, Fajardo, King 2013].
#include "render/scene/light.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/srgb.h"
#include "render/scene/fast_math.h"

namespace umax {

using rows::DirectionRows;
using rows::Row;

namespace {

constexpr float pi = 3.14159265f;

// below this many steradians choosing by area is as good, much cheaper, and loses no digits
constexpr float least_solid_angle = 0.25f;

// without branches, in one form for all compilers' vector code
inline float clamped(float value, float low, float high) {
  return value < low ? low : high < value ? high : value;
}
inline float larger(float a, float b) {
  return a < b ? b : a;
}

// A rectangle as seen from a point: bounds of its local coordinates, angles between its edges' planes.
struct SphericalRectangle {
  float x0, x1, y0, y1, z0;  // local coordinates of the edges; z0 < 0
  float b0, b1, k;           // z components of two edge normals; angle to subtract
  float solid_angle;
};

// corner angles are acos(-n0 n1), ...; two of them are added as rotations
inline float add_corners(float c, float d) {
  const float sc = std::sqrt(larger(0.0f, 1 - c * c)), sd = std::sqrt(larger(0.0f, 1 - d * d));
  const float angle = fast_atan2(sc * d + c * sd, c * d - sc * sd);
  return angle < 0 ? angle + 2 * pi : angle;
}

inline SphericalRectangle project(float x0, float x1, float y0, float y1, float distance) {
  SphericalRectangle s{
      .x0 = x0, .x1 = x1, .y0 = y0, .y1 = y1, .z0 = -distance, .b0 = 0, .b1 = 0, .k = 0, .solid_angle = 0};
  // z components of the unit normals of the four planes through the eye and an edge
  const float z0 = s.z0;
  const float n0z = -y0 / std::sqrt(z0 * z0 + y0 * y0), n2z = y1 / std::sqrt(z0 * z0 + y1 * y1);
  const float n1z = x1 / std::sqrt(z0 * z0 + x1 * x1), n3z = -x0 / std::sqrt(z0 * z0 + x0 * x0);
  const float g01 = add_corners(-n0z * n1z, -n1z * n2z), g23 = add_corners(-n2z * n3z, -n3z * n0z);
  s.b0 = n0z;
  s.b1 = n2z;
  s.k = 2 * pi - g23;
  s.solid_angle = g01 - s.k;
  return s;
}

struct Place {
  float x, y;
};

// local x and y of the point that splits the solid angle as u and v do
inline Place pick(const SphericalRectangle& s, float u, float v) {
  const SinCos a = sin_cos(u * s.solid_angle + s.k);
  const float f = (a.cosine * s.b0 - s.b1) / a.sine;
  const float c = clamped(std::copysign(1.0f, f) / std::sqrt(f * f + s.b0 * s.b0), -1.0f, 1.0f);
  const float x = clamped(-(c * s.z0) / larger(std::sqrt(1 - c * c), 1e-7f), s.x0, s.x1);
  const float d = std::sqrt(x * x + s.z0 * s.z0);
  const float h0 = s.y0 / std::sqrt(d * d + s.y0 * s.y0), h1 = s.y1 / std::sqrt(d * d + s.y1 * s.y1);
  const float h = h0 + v * (h1 - h0), h2 = h * h;
  const float y = h2 < 1 - 1e-6f ? h * d / std::sqrt(1 - h2) : s.y1;
  return {x, clamped(y, s.y0, s.y1)};
}

// a rectangle for loops over rows
struct RectangleNumbers {
  Direction corner, normal, axis_u, axis_v;
  float length_u, length_v, area;
  bool right_angled;
};

// samples on their way: uniform numbers and chances of their lights, and where they go
struct Aim {
  Row u, chance;
  Row density{};  // [1/sr] of those by solid angle; 0: by area
  Row height{};   // [m] over the light's plane
  DirectionRows to_point{};
};

// Points of a light by area, for the samples that chose it; marks those that are better chosen by solid angle, with
// density 1, and returns their number.
int aim_by_area(const RectangleNumbers& light, int index, const rows::RowOf<int>& chosen, const DirectionRows& from,
                const Row& v, int count, Aim& aim) {
  int num_by_angle = 0;
  for (int i = 0; i < count; ++i) {
    const Direction to_corner = light.corner - from.at(i), kept = aim.to_point.at(i);
    const float height = -dot(to_corner, light.normal);
    const Direction to_middle =
        to_corner + (0.5f * light.length_u) * light.axis_u + (0.5f * light.length_v) * light.axis_v;
    const float middle2 = dot(to_middle, to_middle);
    const bool is_large = light.right_angled & (light.area * height > least_solid_angle * middle2 * std::sqrt(middle2));
    const bool mine = chosen[i] == index, by_angle = mine & is_large & (height > 1e-6f) & (aim.chance[i] > 0);
    const Direction point =
        to_corner + (aim.u[i] * light.length_u) * light.axis_u + (v[i] * light.length_v) * light.axis_v;
    aim.to_point.set(i, Direction{mine ? point.x : kept.x, mine ? point.y : kept.y, mine ? point.z : kept.z});
    const float marked = by_angle ? 1.0f : 0.0f;
    aim.height[i] = mine ? height : aim.height[i];
    aim.density[i] = mine ? marked : aim.density[i];
    num_by_angle += by_angle ? 1 : 0;
  }
  return num_by_angle;
}

// points of a light by solid angle, where aim_by_area() asked for it
void aim_by_angle(const RectangleNumbers& light, int index, const rows::RowOf<int>& chosen, const DirectionRows& from,
                  const Row& v, int count, Aim& aim) {
  for (int i = 0; i < count; ++i) {
    const bool by_angle = (chosen[i] == index) & (aim.density[i] > 0);
    const Direction to_corner = light.corner - from.at(i), kept = aim.to_point.at(i);
    const float x0 = dot(to_corner, light.axis_u), y0 = dot(to_corner, light.axis_v);
    const SphericalRectangle s = project(x0, x0 + light.length_u, y0, y0 + light.length_v, aim.height[i]);
    const Place p = pick(s, aim.u[i], v[i]);
    const Direction point = p.x * light.axis_u + p.y * light.axis_v - aim.height[i] * light.normal;
    aim.to_point.set(i,
                     Direction{by_angle ? point.x : kept.x, by_angle ? point.y : kept.y, by_angle ? point.z : kept.z});
    aim.density[i] = by_angle ? 1 / s.solid_angle : aim.density[i];
  }
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

// which light; the number that chose it is stretched to serve again
void RectangleLights::choose(const DirectionRows& from, const Row& u, int count, LightRows& to, Row& again,
                             Row& chance) const {
  for (int i = 0; i < count; ++i) to.light[i] = 0, again[i] = u[i], chance[i] = 1;
  if (lights_.size() <= 1) return;
  Row total, below, g, g_next;
  rows::RowOf<int> is_chosen;
  const auto guess_row = [&](const Rectangle& light, Row& row) {
    const Direction corner = direction_of(light.corner), normal = direction_of(light.normal);
    const Direction middle =
        direction_of(light.corner + 0.5f * light.length_u * light.axis_u + 0.5f * light.length_v * light.axis_v);
    const float power = light.power, area = light.area;
    for (int i = 0; i < count; ++i) {
      const bool bright_side = dot(from.at(i) - corner, normal) > 0;
      const Direction away = middle - from.at(i);
      row[i] = bright_side ? power / larger(dot(away, away), area) : 0.0f;
    }
  };
  for (int i = 0; i < count; ++i) total[i] = 0;
  for (const Rectangle& light : lights_) {
    guess_row(light, g);
    for (int i = 0; i < count; ++i) total[i] += g[i];
  }
  guess_row(lights_[0], g);
  for (int i = 0; i < count; ++i) below[i] = 0, is_chosen[i] = 0;
  for (std::size_t next = 1; next < lights_.size(); ++next) {
    guess_row(lights_[next], g_next);
    for (int i = 0; i < count; ++i) {
      const bool goes_on = (is_chosen[i] == 0) & (u[i] * total[i] >= below[i] + g[i]);
      is_chosen[i] = goes_on ? 0 : 1;
      below[i] = goes_on ? below[i] + g[i] : below[i];
      g[i] = goes_on ? g_next[i] : g[i];
      to.light[i] = goes_on ? int(next) : to.light[i];
    }
  }
  for (int i = 0; i < count; ++i) {
    const bool possible = (total[i] > 0) & (g[i] > 0);
    again[i] = clamped((u[i] * total[i] - below[i]) / g[i], 0.0f, 0.99999994f);
    chance[i] = possible ? g[i] / total[i] : 0.0f;
  }
}

void RectangleLights::sample(const DirectionRows& from, const Row& u, const Row& v, int count, LightRows& to) const {
  Aim aim;
  choose(from, u, count, to, aim.u, aim.chance);
  Row areas;
  for (std::size_t index = 0; index < lights_.size(); ++index) {
    const Rectangle& light = lights_[index];
    const RectangleNumbers numbers{.corner = direction_of(light.corner),
                                   .normal = direction_of(light.normal),
                                   .axis_u = direction_of(light.axis_u),
                                   .axis_v = direction_of(light.axis_v),
                                   .length_u = light.length_u,
                                   .length_v = light.length_v,
                                   .area = light.area,
                                   .right_angled = light.right_angled};
    if (aim_by_area(numbers, int(index), to.light, from, v, count, aim) > 0)
      aim_by_angle(numbers, int(index), to.light, from, v, count, aim);
  }
  for (int i = 0; i < count; ++i) areas[i] = lights_[to.light[i]].area;
  for (int i = 0; i < count; ++i) {
    const float distance2 = dot(aim.to_point.at(i), aim.to_point.at(i)), distance = std::sqrt(distance2);
    const bool possible = (aim.chance[i] > 0) & (aim.height[i] > 1e-6f);
    to.distance[i] = distance;
    to.direction.set(i, aim.to_point.at(i) / distance);
    const float by_area = distance2 * distance / (aim.height[i] * areas[i]);
    to.density[i] = possible ? aim.chance[i] * (aim.density[i] == 0 ? by_area : aim.density[i]) : 0.0f;
  }
}

LightSample RectangleLights::sample(const Vector3f& from, const Vector2f& u) const {
  DirectionRows from_row;
  Row u_row, v_row;
  LightRows to;
  from_row.set(0, from), u_row[0] = u.x(), v_row[0] = u.y();
  sample(from_row, u_row, v_row, 1, to);
  if (!(to.density[0] > 0)) return {};
  return {.direction = to.direction.vector(0),
          .distance = to.distance[0],
          .radiance = lights_[to.light[0]].radiance,
          .density = to.density[0]};
}

void RectangleLights::meet(const rows::RayRows& rays, int count, bool from_camera, LightMetRows& met) const {
  for (int i = 0; i < count; ++i) met.light[i] = -1, met.distance[i] = rays.max_distance[i];
  for (std::size_t index = 0; index < lights_.size(); ++index) {
    const Rectangle& light = lights_[index];
    if (from_camera && !light.visible) continue;
    const Direction corner = direction_of(light.corner), normal = direction_of(light.normal);
    const Direction axis_u = direction_of(light.axis_u), axis_v = direction_of(light.axis_v);
    const float length_u = light.length_u, length_v = light.length_v;
    // coordinates along both edges, also where they are not at right angles
    const float skew = dot(axis_u, axis_v), scale = 1 / (1 - skew * skew);
    for (int i = 0; i < count; ++i) {
      const float approach = -dot(rays.direction.at(i), normal);
      const Direction from_corner = rays.origin.at(i) - corner;
      const float distance = dot(from_corner, normal) / approach;
      const Direction p = from_corner + distance * rays.direction.at(i);
      const float pu = dot(p, axis_u), pv = dot(p, axis_v);
      const float u = (pu - skew * pv) * scale, v = (pv - skew * pu) * scale;
      const bool in_front = (approach > 0) & (distance > 0) & (distance < met.distance[i]);
      const bool is_met = in_front & (u >= 0) & (u <= length_u) & (v >= 0) & (v <= length_v);
      met.light[i] = is_met ? int(index) : met.light[i];
      met.distance[i] = is_met ? distance : met.distance[i];
    }
  }
}

RectangleLights::Met RectangleLights::meet(const Vector3f& origin, const Vector3f& direction, float max_distance,
                                           bool from_camera) const {
  rows::RayRows ray;
  LightMetRows met;
  ray.set(0, {.origin = origin, .direction = direction, .max_distance = max_distance});
  meet(ray, 1, from_camera, met);
  return {.light = met.light[0], .distance = met.distance[0]};
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
