#include "tools/pictures/map_picture.h"

#include <algorithm>
#include <vector>

#include "render/annotation/annotate.h"
#include "render/raster/rasterize.h"
#include "tools/pictures/plot_scale.h"
#include "tools/pictures/shot.h"

namespace umax {
namespace {

constexpr int view_width = 640, view_height = 720, bar_width = 190, gap = 4;  // [px]

/// From the least to the largest factor, rounded outwards; around 1 where all are alike.
Legend legend_of(const VectorXd& factors, const std::string& title) {
  const double least = factors.minCoeff(), largest = factors.maxCoeff();
  Legend legend{.title = title, .low = 0.5, .high = 2, .logarithmic = true};
  if (least == largest && least == 1) return legend;
  const Scale scale = make_scale({.logarithmic = true}, std::min(least, 1.0), std::max(largest, 1.0), 0, 1, 6, true);
  legend.low = scale.low;
  legend.high = scale.high;
  return legend;
}

/// A soft lamp above the camera's left shoulder.
AreaLight lamp_beside(const Camera& camera, double size) {
  const Vector3d target = camera.target.cast<double>(), back = camera.position.cast<double>() - target;
  const Vector3d left = back.cross(Vector3d::UnitY()).normalized();
  const double distance = back.norm();
  LightDescription lamp{.name = "lamp"};
  lamp.target = target;
  lamp.position = target + back + distance * (0.45 * left + 0.6 * Vector3d::UnitY());
  lamp.size = 0.6 * size;
  lamp.power = 5.5 * distance * distance;
  return area_light(lamp);
}

/// The camera in front of the box, or as far behind it.
Camera camera_of_view(const Box& box, bool from_behind) {
  CameraDescription description;
  description.vertical_fov_degrees = 24;
  Camera camera = frame_camera(description, box, double(view_width) / view_height);
  const Vector3f back = camera.position - camera.target;
  if (from_behind) camera.position = camera.target + Vector3f(-back.x(), back.y(), -back.z());
  return camera;
}

Image8 draw_view(const Simulation& simulation, const Stage& stage, const State& state, const VectorXd& factors,
                 bool from_behind, Rasterizer& rasterizer, int threads) {
  const Box box = box_of(simulation, state.positions);
  const Camera camera = camera_of_view(box, from_behind);
  RenderScene shot = make_shot(simulation, stage, state, camera, factors);
  shot.objects.resize(simulation.bodies.size());
  shot.lights = {lamp_beside(camera, box.diagonal().norm())};
  shot.sky = ConstantSky{{0.62f, 0.63f, 0.65f}};
  shot.backdrop = Vector3f(0.055f, 0.06f, 0.07f);
  shot.exposure_stops = 0;
  shot.legend.reset();
  Image8 view = present(rasterizer.draw(shot, {.width = view_width, .height = view_height, .threads = threads}), shot);
  draw_label(view, from_behind ? "back" : "front", 0.02f, 0.02f, {.size = 0.035f});
  return view;
}

/// The views side by side, and room for the bar at their right.
Image8 side_by_side(const std::vector<Image8>& views) {
  Image8 picture(int(views.size()) * (view_width + gap) + bar_width, view_height, 3);
  for (std::size_t i = 0; i < picture.values.size(); i += 3)
    picture.values[i] = 24, picture.values[i + 1] = 26, picture.values[i + 2] = 30;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (int y = 0; y < view_height; ++y)
      std::copy_n(views[i].pixel(0, y), 3 * view_width, picture.pixel(int(i) * (view_width + gap), y));
  return picture;
}

}  // namespace

Image8 map_picture(const Simulation& simulation, const VectorXd& factors, const std::string& title, int threads) {
  const State state = rest_state(simulation.model);
  Stage stage = make_stage(simulation, box_of(simulation, state.positions));
  stage.legend = legend_of(factors, title);
  Rasterizer rasterizer(threads);
  std::vector<Image8> views;
  for (const bool from_behind : {false, true})
    views.push_back(draw_view(simulation, stage, state, factors, from_behind, rasterizer, threads));
  Image8 picture = side_by_side(views);
  draw_legend(picture, *stage.legend);
  return picture;
}

}  // namespace umax
