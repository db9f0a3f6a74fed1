#include "tools/pictures/map_picture.h"

#include <algorithm>
#include <vector>

#include "render/annotation/annotate.h"
#include "render/raster/rasterize.h"
#include "tools/pictures/plot_scale.h"
#include "tools/pictures/studio_view.h"

namespace umax {
namespace {

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
  light_evenly(simulation, box.diagonal().norm(), shot);
  Image8 view = present(rasterizer.draw(shot, {.width = view_width, .height = view_height, .threads = threads}), shot);
  draw_label(view, from_behind ? "back" : "front", 0.02f, 0.02f, {.size = 0.035f});
  return view;
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
  return side_by_side(views, *stage.legend);
}

}  // namespace umax
