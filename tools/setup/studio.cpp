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

/// The ground passes into the horizon within `fade` [m] of something 2 m tall.
ObstacleDescription ground(const Vector3f& color, double fade, double scale, double floor) {
  ObstacleDescription ground;
  ground.name = "ground";
  ground.friction = 0.5;
  ground.position = Vector3d(0, floor, 0);
  ground.fade = fade * scale;
  ground.look.base_color = color;
  ground.look.roughness = 0.75f;
  return ground;
}

// The far ground and the backdrop above it are about as bright, so that nothing tells where one ends. The lights' own
// planes meet the ground behind what is seen of it: in front of a lamp's plane is light, behind it is none.
void add_studio(Scene& scene, double scale, double floor) {
  scene.lights.push_back(light("key", {-4, 6.4, 4.6}, 3.4, 980, {1, 0.95, 0.88}, scale, floor));
  scene.lights.push_back(light("rim", {3.6, 5.6, -5}, 2.4, 1100, {0.85, 0.92, 1}, scale, floor));
  scene.render.sky =
      GradientSky{.horizon = {0.165f, 0.175f, 0.195f}, .zenith = {0.25f, 0.27f, 0.31f}, .ground = {0.2f, 0.2f, 0.2f}};
  scene.obstacles.push_back(ground({0.34f, 0.34f, 0.35f}, 9, scale, floor));
}

void add_sky(Scene& scene, double scale, double floor) {
  scene.render.sky = DaylightSky{.sun_direction = {-0.55f, 0.62f, 0.56f}, .intensity = 2.2f, .sun_size_degrees = 1.5f};
  scene.obstacles.push_back(ground({0.42f, 0.4f, 0.36f}, 40, scale, floor));
}

void add_plain(Scene& scene, double scale, double floor) {
  scene.lights.push_back(light("key", {-3, 7, 5}, 6, 800, {1, 1, 1}, scale, floor));
  scene.render.sky = ConstantSky{{0.6f, 0.6f, 0.6f}};
  scene.render.backdrop = Vector3f(0.85f, 0.85f, 0.85f);
  scene.obstacles.push_back(ground({0.75f, 0.75f, 0.75f}, 6, scale, floor));
}

}  // namespace

void add_stage(Scene& scene, Staging staging, double size, double floor) {
  const double scale = size / 2;
  scene.camera.vertical_fov_degrees = 32;
  if (staging == Staging::studio) add_studio(scene, scale, floor);
  if (staging == Staging::sky) add_sky(scene, scale, floor);
  if (staging == Staging::plain) add_plain(scene, scale, floor);
}

Look studio_look(bool has_own_colors) {
  Look look;
  if (!has_own_colors) look.base_color = {0.5f, 0.18f, 0.07f};
  look.roughness = 0.38f;
  look.clearcoat = 0.35f;
  return look;
}

}  // namespace umax
