#include "tools/pictures/studio_view.h"

#include <algorithm>

#include "render/annotation/annotate.h"

namespace umax {
namespace {

constexpr int bar_width = 190, gap = 4;  // [px]

/// A soft lamp above the camera's left shoulder.
AreaLight lamp_beside(const Camera& camera, double size) {
  const Vector3d target = camera.target.cast<double>(), back = camera.position.cast<double>() - target;
  const Vector3d left = back.cross(Vector3d::UnitY()).normalized();
  const double distance = back.norm();
  LightDescription lamp{.name = "lamp"};
  lamp.target = target;
  lamp.position = Vector3d(target + back + distance * (0.45 * left + 0.6 * Vector3d::UnitY()));
  lamp.size = 0.6 * size;
  lamp.power = 5.5 * distance * distance;
  return area_light(lamp);
}

}  // namespace

void light_evenly(const Simulation& simulation, double size, RenderScene& shot) {
  shot.objects.resize(simulation.bodies.size());
  shot.lights = {lamp_beside(shot.camera, size)};
  shot.sky = ConstantSky{{0.62f, 0.63f, 0.65f}};
  shot.backdrop = Vector3f(0.055f, 0.06f, 0.07f);
  shot.exposure_stops = 0;
  shot.legend.reset();
}

Image8 side_by_side(const std::vector<Image8>& views, const Legend& legend) {
  Image8 picture(int(views.size()) * (view_width + gap) + bar_width, view_height, 3);
  for (std::size_t i = 0; i < picture.values.size(); i += 3)
    picture.values[i] = 24, picture.values[i + 1] = 26, picture.values[i + 2] = 30;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (int y = 0; y < view_height; ++y)
      std::copy_n(views[i].pixel(0, y), 3 * view_width, picture.pixel(int(i) * (view_width + gap), y));
  draw_legend(picture, legend);
  return picture;
}

}  // namespace umax
