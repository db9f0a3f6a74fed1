#include "tools/pictures/strip.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "tools/pictures/shot.h"

namespace umax {
namespace {

constexpr double gap_share = 0.14;       // [-] between neighbours, of the mean width
constexpr double room_for_words = 0.17;  // [-] below the things, of their height
constexpr double room_for_bar = 0.11;    // [-] at their right, of their width

/// How the strip is seen: `right` runs along it, horizontally.
struct View {
  Vector3d back, right;
};

View view_of(const StripItem& item) {
  const CameraDescription& description = item.simulation->scene.camera;
  const Camera camera = frame_camera(description, box_of(*item.simulation, item.state.positions), 1);
  const Vector3d back = (camera.position - camera.target).cast<double>().normalized();
  return {back, Vector3d::UnitY().cross(back).normalized()};
}

TriangleMesh moved(const TriangleMesh& mesh, const Vector3d& by) {
  TriangleMesh out = mesh;
  out.positions.rowwise() += by.transpose();
  return out;
}

/// The objects of an item's shot: half spaces, which all items share, and the rest, bodies first.
struct Things {
  std::vector<RenderObject> ground, others;
  std::size_t num_bodies = 0;
};

Things sort_things(const Simulation& simulation, const RenderScene& shot) {
  Things things;
  things.num_bodies = simulation.bodies.size();
  things.others.assign(shot.objects.begin(), shot.objects.begin() + std::ptrdiff_t(things.num_bodies));
  std::size_t next = things.num_bodies;
  for (std::size_t i = 0; i < simulation.obstacles.size(); ++i)
    if (simulation.scene.obstacles[i].visible)
      (simulation.obstacles[i].mesh ? things.others : things.ground).push_back(shot.objects[next++]);
  return things;
}

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
};

/// Of the bodies, along a direction.
Extent extent_along(const Things& things, const Vector3d& direction) {
  Extent extent;
  for (std::size_t i = 0; i < things.num_bodies; ++i) {
    const VectorXd along = things.others[i].mesh->positions * direction;
    extent.low = std::min(extent.low, along.minCoeff());
    extent.high = std::max(extent.high, along.maxCoeff());
  }
  return extent;
}

/// Where the items' middles stand along the strip, around 0.
std::vector<double> places_of(const std::vector<Extent>& extents) {
  double sum = 0;
  for (const Extent& extent : extents) sum += extent.high - extent.low;
  const double gap = gap_share * sum / double(extents.size());
  std::vector<double> places;
  double next = -0.5 * (sum + gap * double(extents.size() - 1));
  for (const Extent& extent : extents) {
    const double width = extent.high - extent.low;
    places.push_back(next + 0.5 * width);
    next += width + gap;
  }
  return places;
}

/// A copy of each light for every place; together they light an item as bright, on average, as one alone.
std::vector<AreaLight> lights_along(const std::vector<LightDescription>& lights, const std::vector<double>& places,
                                    const Vector3d& right) {
  std::vector<AreaLight> all;
  for (const LightDescription& light : lights) {
    const Vector3d position = light.position.at(0), target = light.target.at(0);
    const double distance = (target - position).norm();
    double received = 0;
    for (const double at : places)
      for (const double from : places) received += std::pow(1 + std::pow((at - from) / distance, 2), -1.5);
    for (const double place : places) {
      LightDescription copy = light;
      copy.position = Vector3d(position + place * right);
      copy.target = Vector3d(target + place * right);
      copy.power = light.power.at(0) * double(places.size()) / received;
      all.push_back(area_light(copy));
    }
  }
  return all;
}

/// The middle of each item in the picture, in [0, 1] of its width.
float place_in_picture(const Camera& camera, const Vector3d& point, const Vector3d& right, double aspect) {
  const Vector3d forward = (camera.target - camera.position).cast<double>().normalized();
  const Vector3d from_camera = point - camera.position.cast<double>();
  const double half = std::tan(double(camera.vertical_fov_degrees) * std::numbers::pi / 360) * aspect;
  return float(0.5 + 0.5 * from_camera.dot(right) / (from_camera.dot(forward) * half));
}

/// Moves an item's things and appends its bodies' vertices.
void move_things(Things& things, const Vector3d& by, Points& points) {
  for (std::size_t k = 0; k < things.others.size(); ++k) {
    RenderObject& thing = things.others[k];
    thing.mesh = std::make_shared<const TriangleMesh>(moved(*thing.mesh, by));
    if (k >= things.num_bodies) continue;
    points.conservativeResize(points.rows() + thing.mesh->num_vertices(), 3);
    points.bottomRows(thing.mesh->num_vertices()) = thing.mesh->positions;
  }
}

/// Widens what is to be seen: below for words, at the right for a bar.
void add_room(Points& points, const View& view, bool for_words, bool for_bar) {
  const auto add = [&](const Vector3d& axis, double share) {
    const VectorXd along = points * axis;
    Eigen::Index end = 0;
    along.maxCoeff(&end);
    const Vector3d beyond = points.row(end).transpose() + share * (along.maxCoeff() - along.minCoeff()) * axis;
    points.conservativeResize(points.rows() + 1, 3);
    for (int k = 0; k < 3; ++k) points(points.rows() - 1, k) = beyond[k];
  };
  if (for_words) add(-Vector3d::UnitY(), room_for_words);
  if (for_bar) add(view.right, room_for_bar);
}

}  // namespace

RenderScene make_strip(const std::vector<StripItem>& items, double aspect) {
  const Simulation& first = *items.front().simulation;
  const View view = view_of(items.front());
  HeatRange range;
  for (const StripItem& item : items) extend(range, *item.simulation, item.state);

  // each by itself, all on one bar
  RenderScene strip;
  std::vector<Things> things;
  std::vector<Extent> extents;
  for (const StripItem& item : items) {
    Stage stage = make_stage(*item.simulation, box_of(*item.simulation, item.state.positions), range);
    stage.legend = heat_legend(first, range);
    RenderScene shot = make_shot(*item.simulation, stage, item.state, Camera());
    things.push_back(sort_things(*item.simulation, shot));
    extents.push_back(extent_along(things.back(), view.right));
    if (things.size() == 1) strip = std::move(shot);
  }

  // the ground stays, everything else goes to its place
  strip.objects = things.front().ground;
  strip.wires.reset();
  const std::vector<double> places = places_of(extents);
  Points points(0, 3);
  for (std::size_t i = 0; i < items.size(); ++i) {
    move_things(things[i], (places[i] - 0.5 * (extents[i].low + extents[i].high)) * view.right, points);
    strip.objects.insert(strip.objects.end(), things[i].others.begin(), things[i].others.end());
  }

  const Vector3d middle = points.colwise().mean().transpose();
  add_room(points, view, std::any_of(items.begin(), items.end(), [](const StripItem& i) { return !i.label.empty(); }),
           strip.legend.has_value());
  strip.lights = lights_along(first.scene.lights, places, view.right);
  strip.camera = frame_points(first.scene.camera, points, aspect, view.back);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Vector3d place = middle + (places[i] - middle.dot(view.right)) * view.right;
    if (!items[i].label.empty())
      strip.captions.push_back({items[i].label, place_in_picture(strip.camera, place, view.right, aspect), 0.90f});
  }
  return strip;
}

}  // namespace umax
