#include "core/contact/held_vertex.h"

#include <algorithm>
#include <limits>

#include "core/contact/encounters.h"

namespace umax {
namespace {

constexpr double same_side = 0.5;  // [-] cosine of normals of the side that a vertex came through
constexpr double at_surface = 2;   // [penetration tolerances] of a vertex that may have come in by any side
constexpr double anywhere = std::numeric_limits<double>::infinity();
constexpr double rounding = 1 + 1e-9;

SurfaceHit nearest_within(const ScaledSurface& surface, const Vector3d& point, const DistanceBounds& bounds) {
  return nearest_point(surface, point, std::max(std::abs(bounds.low), std::abs(bounds.high)));
}
SurfaceHit nearest_within(const ScaledSurface& surface, const Vector3d& point) {
  return nearest_within(surface, point, distance_bounds(surface, point));
}

// how the vertex is away from the other place at the positions, seen from the material there [m]
Vector3d away_at(const Model& model, const Points& positions, const HeldVertex& held) {
  return held.F_inverse *
         (embedded_position(model, positions, held.vertex) - embedded_position(model, positions, held.other));
}

// [m] how far the point is behind the triangle's plane
double depth_behind(const ScaledSurface& surface, int triangle, const Vector3d& point) {
  return triangle_normal(surface, triangle).dot(surface.scale * corner_of(surface.of, triangle, 0) - point);
}

// How deep [m] the way from X0 to X is inside, at most, if it comes in by one triangle and leaves by another that meets it
// in a ridge; any, if it comes in twice.
double ridge_depth(const ScaledSurface& surface, const HeldVertex& held, int entered, int left) {
  if (last_entered(surface, held.X0, held.X) != entered) return anywhere;
  return std::min(depth_behind(surface, entered, held.X), depth_behind(surface, left, held.X0));
}

// What a vertex outside at X0 meets at X. One that is hardly inside may be at a side next to the one that it came in by, and
// one that is outside again may have cut the ridge between both: a body that slides over vertices which it rests on comes
// upon them with its front, and leaves them with its back.
// clear: as in Touch.
SurfaceHit hit_from_outside(const ScaledSurface& surface, const HeldVertex& held, double tolerance, double& clear) {
  const SurfaceHit nearest = nearest_within(surface, held.X, held.bounds);
  if (nearest.triangle < 0) return nearest;
  const bool is_inside = nearest.distance < 0;
  const int entered = !is_inside && nearest.distance > held.moved ? -1 : first_entered(surface, held.X0, held.X);
  if (!is_inside && entered < 0) {
    clear = nearest.distance;
    return nearest;
  }
  const Vector3d side = entered < 0 ? nearest_within(surface, held.X0).normal : triangle_normal(surface, entered);
  const double alikeness = triangle_normal(surface, nearest.triangle).dot(side);
  const double depth = is_inside ? -nearest.distance : ridge_depth(surface, held, entered, nearest.triangle);
  if (depth < at_surface * tolerance && alikeness > -same_side) return nearest;
  const bool is_alike = alikeness >= same_side;
  const double reach = is_alike ? std::abs(nearest.distance) : entered < 0 ? anywhere : held.moved;
  const SurfaceHit alike = nearest_alike(surface, held.X, side, same_side, rounding * reach);
  return alike.triangle >= 0 ? alike : nearest;
}

// a normal of the touched body's rest surface, carried into the world; its length: what distances are divided by
Vector3d pushed_forward(const Model& model, const HeldVertex& held, const Vector3d& normal) {
  return held.F_inverse.transpose() * (body_of(model, held.other.hex).rest_pose.rotation * normal);
}

// the other way round: of a plane with this normal in the world, unit
Vector3d seen_at_rest(const Model& model, const HeldVertex& held, const Vector3d& normal) {
  const Matrix3d F = held.F_inverse.inverse();
  return (body_of(model, held.other.hex).rest_pose.rotation.transpose() * (F.transpose() * normal)).normalized();
}

// is the point farther from the surface than `by`, on its outside?
bool is_outside(const ScaledSurface& surface, const Vector3d& X, double by) {
  const DistanceBounds bounds = distance_bounds(surface, X);
  return bounds.low > by || (bounds.high > by && nearest_within(surface, X, bounds).distance > by);
}

// The vertex as the body that holds it now saw it at the step's start; false where no hex of that held it. The hex that holds
// it now may have turned or bent since, and not tell.
bool hold_at_start(const ContactStep& step, const HeldVertex& held, HeldVertex& at_start) {
  const Model& model = *step.model;
  const Points& start = step.positions_t0;
  const Vector3d position = embedded_position(model, start, held.vertex);
  const int hex = held.vertex.hex, other = held.other.hex;
  return hold(model, start, held.vertex, position, hex_maps(model, start, other), within_hex, at_start) ||
         hold_any(model, start, start, held.vertex, position,
                  hexes_at(step, step.boxes_t0, hex, model.hex_body[other], position), at_start);
}

// the nearest of the surface from where a vertex started; triangle -1: it certainly started outside
SurfaceHit nearest_at_start(const ScaledSurface& surface, const Vector3d& X_start) {
  const DistanceBounds bounds = distance_bounds(surface, X_start);
  return bounds.low > 0 ? SurfaceHit{} : nearest_within(surface, X_start, bounds);
}

// What a vertex meets that started deeper than tolerances explain, and is inside; triangle -1: this one did not, or is
// out.
SurfaceHit hit_along(const Model& model, const ScaledSurface& surface, const HeldVertex& held, const Leaving& leaving) {
  HeldVertex at_start;
  if (!hold_at_start(*leaving.step, held, at_start)) return {};
  SurfaceHit hit = nearest_at_start(surface, at_start.X);
  const bool was_deep = hit.triangle >= 0 && hit.distance < -tolerance_between(model, held.vertex.hex, held.other.hex);
  if (!was_deep || is_outside(surface, held.X, 0)) return {};
  hit.normal = seen_at_rest(model, held, leaving.way.direction);
  hit.distance += (held.X - at_start.X).dot(hit.normal);
  return hit;
}

// is it where others go out? It would be in their way.
bool may_come_in(const Model& model, const HeldVertex& held, const Leaving& leaving) {
  return leaving.way.where.contains(embedded_position(model, leaving.step->positions_t0, held.vertex));
}

// was the vertex, when it was last outside, farther inside than rounding and tolerances explain?
bool was_inside(const Model& model, const ScaledSurface& surface, const HeldVertex& held) {
  const double slack = nearly_outside * tolerance_between(model, held.vertex.hex, held.other.hex);
  const DistanceBounds bounds = distance_bounds(surface, held.X0);
  return bounds.low < -slack && nearest_within(surface, held.X0, bounds).distance < -slack;
}

}  // namespace

HeldVertex hold_at(const Model& model, const Points& apart, const Support& vertex, const HexMaps& other,
                   const Vector3d& s) {
  const MaterialPoint material = material_at(other, s);
  const Model::BodyRange& body = body_of(model, other.hex);
  HeldVertex held;
  held.vertex = vertex;
  held.other = {other.hex, material.weights};
  held.F_inverse = material.F_inverse;
  held.X = body.rest_pose.local(material.rest);
  held.X0 = body.rest_pose.local(material.rest + away_at(model, apart, held));
  held.bounds = distance_bounds(surface_of(body), held.X);
  held.moved = (held.X - held.X0).norm();
  return held;
}

bool hold(const Model& model, const Points& apart, const Support& vertex, const Vector3d& position,
          const HexMaps& other, double reach, HeldVertex& held) {
  const std::optional<Vector3d> s = find_local(other, position);
  if (!s || !has_material(other, *s, reach)) return false;
  held = hold_at(model, apart, vertex, other, *s);
  return true;
}

bool hold_any(const Model& model, const Points& apart, const Points& positions, const Support& vertex,
              const Vector3d& position, const std::vector<int>& hexes, HeldVertex& held) {
  return std::any_of(hexes.begin(), hexes.end(), [&](int other) {
    return hold(model, apart, vertex, position, hex_maps(model, positions, other), within_hex, held);
  });
}

std::vector<int> hexes_at(const ContactStep& step, const std::vector<std::vector<Eigen::AlignedBox3d>>& boxes, int hex,
                          int body, const Vector3d& position) {
  const Model& model = *step.model;
  std::vector<int> found;
  for_each_hex_in(step.geometry->touchable.trees[body], boxes[body], Eigen::AlignedBox3d(position), [&](int other) {
    if (body != model.hex_body[hex] || !share_node(model, hex, other)) found.push_back(other);
  });
  std::sort(found.begin(), found.end());
  return found;
}

bool is_clear(const ScaledSurface& surface, const HeldVertex& held) {
  if (!(held.bounds.low > 0)) return false;
  return held.bounds.low > held.moved || held.bounds.low + distance_bounds(surface, held.X0).low > held.moved;
}

double least_gap(const HeldVertex& held) {
  return -std::max(-held.bounds.low, held.moved) * stretch_bound(held.F_inverse.inverse());
}

Touch measure(const Model& model, const HeldVertex& held, const std::optional<Leaving>& leaving) {
  const ScaledSurface surface = surface_of(body_of(model, held.other.hex));
  const double tolerance = tolerance_between(model, held.vertex.hex, held.other.hex);
  SurfaceHit hit;
  double clear = -anywhere;
  if (leaving) hit = hit_along(model, surface, held, *leaving);
  const bool goes_out = hit.triangle >= 0;
  if (!goes_out)
    hit = was_inside(model, surface, held) ? nearest_within(surface, held.X, held.bounds)  // the nearest way out
                                           : hit_from_outside(surface, held, tolerance, clear);
  if (leaving && !goes_out && may_come_in(model, held, *leaving)) hit.distance = std::abs(hit.distance);
  const Vector3d pushed = pushed_forward(model, held, hit.normal);
  return {hit.distance / pushed.norm(), pushed.normalized(), clear};
}

AllowedDepth allowance(const ContactStep& step, const HeldVertex& held) {
  const Model& model = *step.model;
  const int hex = held.vertex.hex, other = held.other.hex;
  HeldVertex at_start;
  if (!hold_at_start(step, held, at_start)) return {};
  const SurfaceHit start = nearest_at_start(surface_of(body_of(model, other)), at_start.X);
  if (start.triangle < 0) return {};
  const std::optional<Leaving> leaving = leaving_of(step, hex, other);
  const Vector3d normal = leaving ? seen_at_rest(model, at_start, leaving->way.direction) : start.normal;
  const double depth = -start.distance / pushed_forward(model, at_start, normal).norm();
  const double recovery = std::min(step.recovery[model.hex_body[hex]], step.recovery[model.hex_body[other]]);
  return allowed_depth(depth, tolerance_between(model, hex, other), recovery);
}

std::optional<Leaving> leaving_of(const ContactStep& step, int hex, int other_hex) {
  const auto& ways = step.deep_start.ways_out;
  if (ways.empty()) return {};
  const auto found = ways.find({step.model->hex_body[hex], step.model->hex_body[other_hex]});
  if (found == ways.end()) return {};
  return Leaving{found->second, &step};
}

}  // namespace umax
