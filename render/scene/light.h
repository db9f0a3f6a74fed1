// Where light comes from: rectangles and skies, and how to aim at them.
#pragma once

#include <memory>
#include <vector>

#include "render/scene/render_scene.h"
#include "render/scene/rows.h"
#include "render/scene/sampling.h"

namespace umax {

/// A direction towards light, chosen by chance.
struct LightSample {
  Vector3f direction{0, 1, 0};  // unit, from the lit point
  float distance = 0;           // [m]
  Vector3f radiance{0, 0, 0};   // [W/(m^2 sr)] that arrives if nothing is in the way
  float density = 0;            // [1/sr]; 0: no sample
};

/// The same for many points: which rectangle, in place of its radiance; where density is 0 there is no sample.
struct LightRows {
  rows::DirectionRows direction;
  rows::Row distance, density;
  rows::RowOf<int> light;
};

/// Nearest rectangles that rays meet; light -1: none.
struct LightMetRows {
  rows::RowOf<int> light;
  rows::Row distance;
};

/// The scene's rectangles, made ready. One is chosen by a guess of what it gives to the lit point.
class RectangleLights {
 public:
  /// Throws Error 65 when an edge has no length or a value is not finite.
  explicit RectangleLights(const std::vector<AreaLight>& lights);
  bool empty() const { return lights_.empty(); }

  LightSample sample(const Vector3f& from, const Vector2f& u) const;
  /// The same bits for `count` points and pairs of uniform numbers at once.
  void sample(const rows::DirectionRows& from, const rows::Row& u, const rows::Row& v, int count, LightRows& to) const;

  struct Met {
    int light = -1;  // -1: none
    float distance = 0;
  };
  /// Nearest rectangle that a ray meets from its bright side.
  Met meet(const Vector3f& origin, const Vector3f& direction, float max_distance, bool from_camera) const;
  /// The same bits for `count` rays at once.
  void meet(const rows::RayRows& rays, int count, bool from_camera, LightMetRows& met) const;
  const Vector3f& radiance(int light) const { return lights_[light].radiance; }
  /// Density [1/sr] with which sample() goes from a point to where a ray from there met a light.
  float density(const Met& met, const Vector3f& from, const Vector3f& direction) const;

 private:
  struct Rectangle {
    Vector3f corner, axis_u, axis_v, normal;  // axes and normal of length 1
    float length_u, length_v, area, power;
    Vector3f radiance;
    bool right_angled, visible;
  };
  static float guess(const Rectangle& light, const Vector3f& from);
  float total_guess(const Vector3f& from) const;
  void choose(const rows::DirectionRows& from, const rows::Row& u, int count, LightRows& to, rows::Row& again,
              rows::Row& chance) const;
  std::vector<Rectangle> lights_;
};

/// A sky made ready: look-ups, and aimed samples where that pays (a sun, the bright parts of a picture).
class SkyLight {
 public:
  /// Throws Error 65 for values that make no sky.
  explicit SkyLight(const Sky& sky);
  ~SkyLight();
  SkyLight(SkyLight&&) noexcept;

  Vector3f radiance(const Vector3f& direction) const;
  /// Whether sample() aims anywhere; if not, directions of the surface's own choice serve best.
  bool is_aimed() const;
  LightSample sample(const Vector2f& u) const;
  float density(const Vector3f& direction) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace umax
