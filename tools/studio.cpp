#include "tools/studio.h"

namespace umax {
namespace {

/// Position and target for a body 2 m tall that stands at height 0.
LightDescription light(const char* name, const Vector3d& position, double size, double power, const Vector3d& color,
                       double scale, double floor) {
  LightDescription light;
  light.name = name;
  light.position = scale * position + Vector3d(0, floor, 0);
  light.target = Vector3d(0, floor + 1.0 * scale, 0);
  light.size = scale * size;
  light.power = scale * scale * power;  // the same radiance from every size
  light.color = color;
  return light;
}

}  // namespace

void add_studio(Scene& scene, double height, double floor) {
  const double scale = height / 2;
  scene.lights.push_back(light("key", {3.5, 5.5, 3.5}, 2.4, 1200, {1, 0.93, 0.83}, scale, floor));
  scene.lights.push_back(light("rim", {-4, 3.5, -3}, 1.6, 450, {0.8, 0.88, 1}, scale, floor));
  scene.render.sky =
      GradientSky{.horizon = {0.72f, 0.76f, 0.82f}, .zenith = {0.28f, 0.4f, 0.6f}, .ground = {0.22f, 0.21f, 0.2f}};
  scene.camera.vertical_fov_degrees = 32;

  ObstacleDescription ground;
  ground.name = "ground";
  ground.friction = 0.5;
  ground.position = Vector3d(0, floor, 0);
  ground.look.base_color = {0.39f, 0.37f, 0.33f};
  ground.look.roughness = 0.65f;
  scene.obstacles.push_back(ground);
  for (BodyDescription& body : scene.bodies) {
    body.look.roughness = 0.38f;
    body.look.clearcoat = 0.35f;
  }
}

}  // namespace umax
