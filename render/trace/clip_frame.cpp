#include "render/trace/clip_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace umax {
namespace {

// the smaller change of distance to the two pixels beside, of those that show the same object
float change_along(const Hit& before, const Hit& here, const Hit& after) {
  constexpr float none = std::numeric_limits<float>::infinity();
  const float a = before.object == here.object ? std::abs(here.distance - before.distance) : none;
  const float b = after.object == here.object ? std::abs(here.distance - after.distance) : none;
  const float change = std::min(a, b);
  return change < none ? change : 0;
}

float slope_at(const std::vector<Hit>& hits, int width, int height, int x, int y) {
  const Hit* here = &hits[std::size_t(y) * width + x];
  if (!here->found()) return 0;
  const Hit nothing;
  return change_along(x > 0 ? here[-1] : nothing, *here, x + 1 < width ? here[1] : nothing) +
         change_along(y > 0 ? here[-width] : nothing, *here, y + 1 < height ? here[width] : nothing);
}

SeenPoint seen_point(const Hit& hit, float slope, const TracedImage& traced, const NoisyLight& noisy, std::size_t i) {
  SeenPoint point;
  for (int c = 0; c < 3; ++c) {
    point.first[c] = noisy.half[c][i];
    point.second[c] = 2 * noisy.light[c][i] - noisy.half[c][i];
    point.albedo[c] = traced.albedo.values[3 * i + c];
    point.normal[c] = traced.normal.values[3 * i + c];
  }
  point.variance = noisy.of_paths[i];
  point.object = hit.object;
  point.distance = hit.distance;
  point.slope = slope;
  return point;
}

// Pixels whose paths may have gone through clear matter: what they show moves otherwise than any surface.
void set_clear_apart(const std::vector<Hit>& hits, const RenderScene& scene, ClipFrame& frame) {
  constexpr int reach = 2;  // [px] of the pixels' filter
  if (std::none_of(scene.objects.begin(), scene.objects.end(),
                   [](const RenderObject& object) { return object.look.transmission > 0; }))
    return;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const Hit& hit = hits[std::size_t(y) * frame.width + x];
      if (!hit.found() || !(scene.objects[hit.object].look.transmission > 0)) continue;
      for (int row = std::max(y - reach, 0); row <= std::min(y + reach, frame.height - 1); ++row)
        for (int column = std::max(x - reach, 0); column <= std::min(x + reach, frame.width - 1); ++column)
          frame.points[std::size_t(row) * frame.width + column].distance = std::numeric_limits<float>::quiet_NaN();
    }
}

// Pixels of what stands still that something passes over while the shutter is open. In other frames it passes elsewhere:
// a trace of it, too faint to be told by its albedo, would be left behind.
void set_swept_apart(const std::vector<Hit>& hits, const RenderScene& scene, const std::vector<char>& edges,
                     ClipFrame& frame) {
  const auto stands_still = [&](const Hit& hit) {
    return !hit.found() || scene.objects[hit.object].motion.instants.size() < 2;
  };
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (edges[i] == swept_edge && stands_still(hits[i]))
      frame.points[i].distance = std::numeric_limits<float>::quiet_NaN();
}

bool is_same(const CameraView& a, const CameraView& b) {
  return a.position == b.position && a.corner == b.corner && a.step_x == b.step_x && a.step_y == b.step_y;
}

bool has_same_triangles(const TriangleMesh& a, const TriangleMesh& b) {
  return a.num_vertices() == b.num_vertices() && a.num_triangles() == b.num_triangles() && a.triangles == b.triangles;
}

Vector3f point_on(const TriangleMesh& mesh, const ClipFrame::Place& place) {
  const auto corner = [&](int c) { return mesh.positions.row(mesh.triangles(place.triangle, c)); };
  const double u = double(place.u), v = double(place.v);
  return ((1 - u - v) * corner(0) + u * corner(1) + v * corner(2)).transpose().cast<float>();
}

}  // namespace

ClipFrame make_clip_frame(const std::vector<Hit>& hits, const RenderScene& scene, const TracedImage& traced,
                          const std::vector<char>& edges) {
  const int width = traced.color.width, height = traced.color.height;
  CameraView view = view_at_moment(scene, width, height);
  view.aperture_radius = 0;
  const NoisyLight noisy = noisy_light(traced);
  ClipFrame frame{.width = width,
                  .height = height,
                  .has_color_noise = traced.has_color_noise(),
                  .projection = Projection(view),
                  .surfaces = {},
                  .points = std::vector<SeenPoint>(hits.size()),
                  .places = std::vector<ClipFrame::Place>(hits.size())};
  for (const RenderObject& object : scene.objects) frame.surfaces.push_back(object.mesh);
  parallel_blocks(height, 16, [&](Eigen::Index begin, Eigen::Index end) {
    for (int y = int(begin); y < int(end); ++y)
      for (int x = 0; x < width; ++x) {
        const std::size_t i = std::size_t(y) * width + x;
        frame.points[i] = seen_point(hits[i], slope_at(hits, width, height, x, y), traced, noisy, i);
        frame.places[i] = {hits[i].triangle, hits[i].u, hits[i].v};
      }
  });
  set_clear_apart(hits, scene, frame);
  set_swept_apart(hits, scene, edges, frame);
  return frame;
}

Reprojection::Reprojection(const ClipFrame& from, const ClipFrame& to)
    : from_(from), to_(to), same_camera_(is_same(from.projection.view, to.projection.view)) {
  const bool as_many = from.surfaces.size() == to.surfaces.size();
  for (std::size_t i = 0; i < from.surfaces.size(); ++i)
    relations_.push_back(as_many ? relation_of(*from.surfaces[i], *to.surfaces[i]) : Relation::other);
}

Reprojection::Relation Reprojection::relation_of(const TriangleMesh& here, const TriangleMesh& there) {
  if (&here == &there) return Relation::same;
  if (!has_same_triangles(here, there)) return Relation::other;
  return here.positions == there.positions ? Relation::same : Relation::moved;
}

Reprojection::Place Reprojection::place(int x, int y) const {
  const SeenPoint& point = from_.point(x, y);
  const bool found = point.object != Hit::nothing;
  Place place{.x = float(x) + 0.5f, .y = float(y) + 0.5f, .distance = point.distance};
  if (found && relations_[point.object] == Relation::other) return {.has_place = false};
  if (stands_still(point.object)) return place;
  Vector3f from_camera = camera_ray(from_.projection.view, float(x) + 0.5f, float(y) + 0.5f, {0, 0}).direction;
  if (found)
    from_camera = point_on(*to_.surfaces[point.object], from_.places[std::size_t(y) * from_.width + x]) -
                  to_.projection.view.position;
  if (!(from_camera.dot(to_.projection.view.forward) > 0)) return {.has_place = false};
  const Vector2f from_middle = to_.projection.place_of_direction(from_camera);
  place.x = 0.5f * float(to_.width) + from_middle.x();
  place.y = 0.5f * float(to_.height) - from_middle.y();
  if (found) place.distance = from_camera.norm();
  return place;
}

}  // namespace umax
