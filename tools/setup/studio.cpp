#include "tools/setup/studio.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

namespace umax {
namespace {

/// Position and target for a body 2 m tall that stands at height 0.
LightDescription light(const char* name, const Vector3d& position, double size, double power, const Vector3d& color,
                       double scale, const Vector3d& foot) {
  LightDescription light;
  light.name = name;
  light.position = Vector3d(scale * position + foot);
  light.target = Vector3d(foot + Vector3d(0, 1.0 * scale, 0));
  light.size = scale * size;
  light.power = scale * scale * power;  // the same radiance from every size
  light.color = color;
  return light;
}

constexpr double studio_fade = 9;

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

bool is_level(const ObstacleDescription& obstacle) {
  const Vector3d turned = obstacle.rotation_degrees.at(0);
  return turned.x() == 0 && turned.z() == 0;
}

// The far ground and the backdrop above it are about as bright, so that nothing tells where one ends. The lights' own
// planes meet the ground behind what is seen of it: in front of a lamp's plane is light, behind it is none.
// colours as scene files keep them, in single precision: a run's scene.toml makes the same pictures
void light_studio(Scene& scene, double scale, const Vector3d& foot) {
  constexpr float key_green = 0.95f, key_blue = 0.88f, rim_red = 0.85f, rim_green = 0.92f;
  scene.lights.push_back(light("key", {-4, 6.4, 4.6}, 3.4, 980, {1, double(key_green), double(key_blue)}, scale, foot));
  scene.lights.push_back(light("rim", {3.6, 5.6, -5}, 2.4, 1100, {double(rim_red), double(rim_green), 1}, scale, foot));
  scene.render.sky =
      GradientSky{.horizon = {0.165f, 0.175f, 0.195f}, .zenith = {0.25f, 0.27f, 0.31f}, .ground = {0.2f, 0.2f, 0.2f}};
}

void add_studio(Scene& scene, double scale, double floor) {
  light_studio(scene, scale, {0, floor, 0});
  scene.obstacles.push_back(ground({0.34f, 0.34f, 0.35f}, studio_fade, scale, floor));
}

void add_sky(Scene& scene, double scale, double floor) {
  scene.render.sky = DaylightSky{.sun_direction = {-0.55f, 0.62f, 0.56f}, .intensity = 2.2f, .sun_size_degrees = 1.5f};
  scene.obstacles.push_back(ground({0.42f, 0.4f, 0.36f}, 40, scale, floor));
}

void add_plain(Scene& scene, double scale, double floor) {
  scene.lights.push_back(light("key", {-3, 7, 5}, 6, 800, {1, 1, 1}, scale, {0, floor, 0}));
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

void light_scene(const Eigen::AlignedBox3d& bodies, Scene& scene) {
  if (!scene.wants_lights || bodies.isEmpty()) return;
  scene.wants_lights = false;
  const Vector3d center = bodies.center();
  // the ground that bodies may fall to, else their lowest point
  double floor = bodies.min().y();
  for (const ObstacleDescription& obstacle : scene.obstacles)
    if (std::holds_alternative<HalfSpace>(obstacle.shape) && is_level(obstacle))
      floor = std::min(floor, obstacle.position.at(0).y());
  const Vector3d size(bodies.sizes().x(), bodies.max().y() - floor, bodies.sizes().z());
  const double scale = std::max(size.y(), 0.7 * std::hypot(size.x(), size.z())) / 2;
  light_studio(scene, scale, {center.x(), floor, center.z()});
  for (ObstacleDescription& obstacle : scene.obstacles) {
    if (!std::holds_alternative<HalfSpace>(obstacle.shape) || obstacle.fade || !is_level(obstacle)) continue;
    const Vector3d beside = obstacle.position.at(0) - Vector3d(center.x(), obstacle.position.at(0).y(), center.z());
    obstacle.fade = studio_fade * scale + beside.norm();
  }
}

Look studio_look(bool has_own_colors, int number) {
  static const std::array<Vector3f, 6> tones{Vector3f(0.5f, 0.18f, 0.07f),    // clay
                                             Vector3f(0.03f, 0.17f, 0.2f),    // petrol
                                             Vector3f(0.52f, 0.29f, 0.05f),   // ochre
                                             Vector3f(0.13f, 0.2f, 0.08f),    // moss
                                             Vector3f(0.52f, 0.43f, 0.32f),   // sand
                                             Vector3f(0.09f, 0.14f, 0.27f)};  // slate
  Look look;
  if (!has_own_colors) look.base_color = tones[std::size_t(number) % tones.size()];
  look.roughness = 0.38f;
  look.clearcoat = 0.35f;
  return look;
}

}  // namespace umax
