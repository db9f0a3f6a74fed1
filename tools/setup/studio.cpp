#include "tools/setup/studio.h"

namespace umax {
namespace {

/// Position and target for a body 2 m tall that stands at height 0.
LightDescription light(const char* name, const Vector3d& position, double size, double power, const Vector3d& color,
                       double scale, double floor) {
  LightDescription light;
  light.name = name;
  light.position = Vector3d(scale * position + Vector3d(0, floor, 0));
  light.target = Vector3d(0, floor + 1.0 * scale, 0);
  light.size = scale * size;
  light.power = scale * scale * power;  // the same radiance from every size
  light.color = color;
  return light;
}

}  // namespace

void add_studio(Scene& scene, double height, double floor) {
  const double scale = height / 2;
  scene.lights.push_back(light("key", {8, 16, 9}, 8, 2600, {1, 0.95, 0.88}, scale, floor));
  scene.lights.push_back(light("rim", {-4, 3.5, -3}, 1.6, 600, {0.8, 0.88, 1}, scale, floor));
  // bright from above and dim at the horizon: ground and sky meet almost without a line
  scene.render.sky =
      GradientSky{.horizon = {0.3f, 0.315f, 0.34f}, .zenith = {0.52f, 0.56f, 0.64f}, .ground = {0.25f, 0.25f, 0.25f}};
  scene.camera.vertical_fov_degrees = 32;

  ObstacleDescription ground;
  ground.name = "ground";
  ground.friction = 0.5;
  ground.position = Vector3d(0, floor, 0);
  ground.look.base_color = {0.62f, 0.61f, 0.6f};
  ground.look.roughness = 0.65f;
  scene.obstacles.push_back(ground);
}

Look studio_look(bool has_own_colors) {
  Look look;
  if (!has_own_colors) look.base_color = {0.5f, 0.18f, 0.07f};
  look.roughness = 0.38f;
  look.clearcoat = 0.35f;
  return look;
}

}  // namespace umax
