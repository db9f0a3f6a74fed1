#include "core/contact/held_vertex.h"

#include <algorithm>
#include <limits>

#include "core/contact/material_point.h"

namespace umax {
namespace {

constexpr double same_side = 0.5;  // [-] cosine of normals of the side that a vertex came through
constexpr double at_surface = 2;   // [penetration tolerances] of a vertex that may have come in by any side
constexpr double way_reach = 1.2;  // times the depth of bodies inside each other, of what counts as their overlap
constexpr double anywhere = std::numeric_limits<double>::infinity();
constexpr double rounding = 1 + 1e-9;

SurfaceHit nearest_within(const RestSurface& surface, const Vector3d& point, const DistanceBounds& bounds) {
  return nearest_point(surface, point, std::max(std::abs(bounds.low), std::abs(bounds.high)));
}
SurfaceHit nearest_within(const RestSurface& surface, const Vector3d& point) {
  return nearest_within(surface, point, distance_bounds(surface, point));
}

// how the vertex is away from the other place at the positions, seen from the material there [m]
Vector3d away_at(const Model& model, const Points& positions, const HeldVertex& held) {
  return held.F_inverse *
         (embedded_position(model, positions, held.vertex) - embedded_position(model, positions, held.other));
}

// What a vertex outside at X0 meets at X. One that is hardly inside may be at a side next to the one that it came in by: a body
// that slides over vertices which it rests on comes upon them with its front.
// clear: as in Touch.
SurfaceHit hit_from_outside(const RestSurface& surface, const HeldVertex& held, double tolerance, double& clear) {
  const SurfaceHit nearest = nearest_within(surface, held.X, held.bounds);
  if (nearest.triangle < 0) return nearest;
  const bool is_inside = nearest.distance < 0;
  const int entered = !is_inside && nearest.distance > held.moved ? -1 : first_entered(surface, held.X0, held.X);
  if (!is_inside && entered < 0) {
    clear = nearest.distance;
    return nearest;
  }
  const Vector3d side = entered < 0 ? nearest_within(surface, held.X0).normal
                                    : Vector3d(surface.triangle_normals.row(entered).transpose());
  const double alikeness = surface.triangle_normals.row(nearest.triangle).dot(side.transpose());
  if (is_inside && nearest.distance > -at_surface * tolerance && alikeness > -same_side) return nearest;
  const bool is_alike = alikeness >= same_side;
  const double reach = is_alike ? std::abs(nearest.distance) : entered < 0 ? anywhere : held.moved;
  const SurfaceHit alike = nearest_alike(surface, held.X, side, same_side, rounding * reach);
  return alike.triangle >= 0 ? alike : nearest;
}

// a normal of the touched body's rest surface, carried into the world; its length: what distances are divided by
Vector3d pushed_forward(const Model& model, const HeldVertex& held, const Vector3d& normal) {
  return held.F_inverse.transpose() * (body_of(model, held.other.hex).rest_pose.rotation * normal);
}

// The triangles by which a vertex at X leaves along the way, if it is inside or at the surface, and not deeper than the
// bodies are.
SurfaceHit hit_along(const Model& model, const HeldVertex& held, const Vector3d& X, const WayOut& way) {
  const Model::BodyRange& body = body_of(model, held.other.hex);
  const Matrix3d F = held.F_inverse.inverse();
  const Vector3d direction = (body.rest_pose.rotation.transpose() * (F.transpose() * way.direction)).normalized();
  return nearest_alike(*body.rest_surface, X, direction, same_side, way_reach * way.depth);
}

// was the vertex, when it was last outside, farther inside than rounding and tolerances explain?
bool was_inside(const Model& model, const RestSurface& surface, const HeldVertex& held) {
  const double slack = nearly_outside * tolerance_between(model, held.vertex.hex, held.other.hex);
  const DistanceBounds bounds = distance_bounds(surface, held.X0);
  return bounds.low < -slack && nearest_within(surface, held.X0, bounds).distance < -slack;
}

// is the point farther from the surface than `by`, on its outside?
bool is_outside(const RestSurface& surface, const Vector3d& X, double by) {
  const DistanceBounds bounds = distance_bounds(surface, X);
  return bounds.low > by || (bounds.high > by && nearest_within(surface, X, bounds).distance > by);
}

}  // namespace

bool hold(const Model& model, const Points& apart, const Points& positions, const Support& vertex,
          const Vector3d& position, int other_hex, double reach, HeldVertex& held) {
  MaterialPoint material;
  if (!find_material(model, positions, other_hex, position, reach, material)) return false;
  const Model::BodyRange& body = body_of(model, other_hex);
  held.vertex = vertex;
  held.other = {other_hex, material.weights};
  held.F_inverse = material.F_inverse;
  held.X = body.rest_pose.local(material.rest);
  held.X0 = body.rest_pose.local(material.rest + away_at(model, apart, held));
  held.bounds = distance_bounds(*body.rest_surface, held.X);
  held.moved = (held.X - held.X0).norm();
  return true;
}

bool is_clear(const RestSurface& surface, const HeldVertex& held) {
  if (!(held.bounds.low > 0)) return false;
  return held.bounds.low > held.moved || held.bounds.low + distance_bounds(surface, held.X0).low > held.moved;
}

double least_gap(const HeldVertex& held) {
  return -std::max(-held.bounds.low, held.moved) * held.F_inverse.inverse().norm();
}

Touch measure(const Model& model, const HeldVertex& held, const WayOut* way) {
  const RestSurface& surface = *body_of(model, held.other.hex).rest_surface;
  const double tolerance = tolerance_between(model, held.vertex.hex, held.other.hex);
  SurfaceHit hit;
  double clear = -anywhere;
  if (way && !is_outside(surface, held.X0, at_surface * tolerance)) hit = hit_along(model, held, held.X, *way);
  if (hit.triangle < 0)
    hit = was_inside(model, surface, held) ? nearest_within(surface, held.X, held.bounds)  // the nearest way out
                                           : hit_from_outside(surface, held, tolerance, clear);
  const Vector3d pushed = pushed_forward(model, held, hit.normal);
  return {hit.distance / pushed.norm(), pushed.normalized(), clear};
}

AllowedDepth allowance(const ContactStep& step, const HeldVertex& held) {
  const Model& model = *step.model;
  const int hex = held.vertex.hex, other = held.other.hex;
  const Model::BodyRange& body = body_of(model, other);
  const Vector3d X_start = held.X + body.rest_pose.rotation.transpose() * away_at(model, step.positions_t0, held);
  const DistanceBounds bounds = distance_bounds(*body.rest_surface, X_start);
  if (bounds.low > 0) return {};
  SurfaceHit start;
  if (const WayOut* way = way_between(step, hex, other)) start = hit_along(model, held, X_start, *way);
  if (start.triangle < 0) start = nearest_within(*body.rest_surface, X_start, bounds);
  const double depth = -start.distance / pushed_forward(model, held, start.normal).norm();
  const double recovery = std::min(step.recovery[model.hex_body[hex]], step.recovery[model.hex_body[other]]);
  return allowed_depth(depth, tolerance_between(model, hex, other), recovery);
}

const WayOut* way_between(const ContactStep& step, int hex, int other_hex) {
  if (step.ways_out.empty()) return nullptr;
  const auto found = step.ways_out.find({step.model->hex_body[hex], step.model->hex_body[other_hex]});
  return found == step.ways_out.end() ? nullptr : &found->second;
}

}  // namespace umax
