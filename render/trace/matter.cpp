#include "render/trace/matter.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "render/trace/bsdf_core.h"

namespace umax {
namespace {

constexpr int most_events = 64;           // at the boundary of clear matter; then light goes straight on
constexpr int most_turns = 1024;          // in cloudy matter; then light comes out where it went in
constexpr float least_weight = 0.05f;     // below which light is ended by chance
constexpr float smooth_roughness = 0.2f;  // through rougher surfaces nothing is told apart

void check(bool is_right, const std::string& where, const char* key, float value, const char* what) {
  if (is_right) return;
  throw Error(
      Fault::bad_data,
      {.where = where + ": " + key, .what = what, .value = std::to_string(value), .remedy = "give another value"});
}

// whether a ray meets a triangle from behind, so from inside of a closed mesh
bool is_from_inside(const RayScene& rays, const Ray& ray, const Hit& hit) {
  return rays.objects()[hit.object].face(hit.triangle, ray.time).dot(ray.direction) > 0;
}

// reflectance of a dielectric; eta: the index beyond the boundary over that before it
float fresnel(float cosine, float eta) {
  const float sine2 = (1 - cosine * cosine) / (eta * eta);
  if (sine2 >= 1) return 1;
  const float beyond = std::sqrt(1 - sine2);
  const float parallel = (eta * cosine - beyond) / (eta * cosine + beyond);
  const float perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond);
  return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

// unit; normal on the side that the light comes from. Thrown back where no light gets through.
Vector3f bent(const Vector3f& direction, const Vector3f& normal, float eta) {
  const float cosine = -direction.dot(normal), k = 1 - (1 - cosine * cosine) / (eta * eta);
  if (!(k > 0)) return direction + 2 * cosine * normal;
  return (direction / eta + (cosine / eta - std::sqrt(k)) * normal).normalized();
}

Vector3f mirrored(const Vector3f& direction, const Vector3f& normal) {
  return direction - 2 * direction.dot(normal) * normal;
}

// a microfacet that is seen from where the light comes from
Vector3f facet(const Vector3f& normal, const Vector3f& direction, float alpha, const Vector2f& u) {
  const Frame frame(normal);
  Vector3f viewer = frame.to_local(-direction);
  viewer.z() = std::max(viewer.z(), 1e-4f);
  const Direction light = bsdf_core::mirrored_direction(alpha, direction_of(viewer), u.x(), u.y());
  return frame.to_world((viewer + Vector3f(light.x, light.y, light.z)).normalized());
}

// Which way light goes on at the boundary. leaves: whether it comes from inside.
Vector3f next_direction(const SurfacePoint& point, const Vector3f& direction, const Matter& matter, bool leaves,
                        const Vector2f& u, float chance) {
  const float eta = leaves ? 1 / matter.ior : matter.ior;
  for (const Vector3f& normal : {facet(point.normal, direction, matter.alpha, u), point.normal}) {
    const float cosine = -direction.dot(normal);
    if (!(cosine > 0)) continue;
    const bool is_thrown_back = leaves && chance < fresnel(cosine, eta);
    const Vector3f next = is_thrown_back ? mirrored(direction, normal) : bent(direction, normal, eta);
    // microfacets hide what they would send through each other
    if ((next.dot(point.geometric_normal) > 0) == is_thrown_back) return next;
  }
  const float cosine = -direction.dot(point.geometric_normal);
  const bool is_thrown_back = leaves && chance < fresnel(cosine, eta);
  return is_thrown_back ? mirrored(direction, point.geometric_normal) : bent(direction, point.geometric_normal, eta);
}

Vector3f absorption(const Vector3f& color, float depth) {
  return -color.cwiseMin(1.0f).cwiseMax(1e-6f).array().log().matrix() / depth;
}

Vector3f what_is_left(const Vector3f& density, float distance) {
  return (-distance * density).array().exp().matrix();
}

// ends light that carries little, so that what goes on carries its share; false: it has ended
bool goes_on(Vector3f& weight, PathRandom& random) {
  const float most = weight.maxCoeff();
  if (most >= least_weight) return true;
  const float chance = most / least_weight;
  if (!(random.next() < chance)) {
    weight.setZero();
    return false;
  }
  weight /= chance;
  return true;
}

Vector3f any_direction(PathRandom& random) {
  const float z = 2 * random.next() - 1, r = std::sqrt(std::max(0.0f, 1 - z * z));
  const SinCos angle = sin_cos(2 * bsdf_core::pi * random.next());
  return {r * angle.cosine, r * angle.sine, z};
}

// The way of one light through cloudy matter.
class Wanderer {
 public:
  Wanderer(const RayScene& rays, const Matter& matter, const Vector3f& color, unsigned object, PathRandom& random)
      : rays_(rays),
        random_(random),
        object_(object),
        density_(matter.radius.cwiseInverse()),
        turning_(density_.cwiseProduct(scattered_share(color))) {}

  /// From just below the surface to a turn or to the boundary, which `hit` then tells.
  Hit go(Ray& ray, Vector3f& weight) {
    const Vector3f shares = weight / weight.sum();
    const int chosen = pick(shares, random_.next());
    ray.max_distance = -std::log(1 - random_.next()) / density_[chosen];
    const Hit hit = rays_.intersect_object(object_, ray);
    const Vector3f left = what_is_left(density_, hit.found() ? hit.distance : ray.max_distance);
    if (hit.found())
      weight = weight.cwiseProduct(left) / shares.dot(left);
    else
      weight = weight.cwiseProduct(turning_).cwiseProduct(left) / shares.dot(density_.cwiseProduct(left));
    return hit;
  }

 private:
  static int pick(const Vector3f& shares, float u) { return u < shares[0] ? 0 : u < shares[0] + shares[1] ? 1 : 2; }
  const RayScene& rays_;
  PathRandom& random_;
  unsigned object_;
  Vector3f density_, turning_;  // [1/m] of ends of straight ways; of those at which light is not absorbed
};

}  // namespace

Matter make_matter(const Look& look, const std::string& where) {
  const auto is_fraction = [](float value) { return value >= 0 && value <= 1; };
  check(is_fraction(look.transmission), where, "transmission", look.transmission, "must lie between 0 and 1");
  check(is_fraction(look.subsurface), where, "subsurface", look.subsurface, "must lie between 0 and 1");
  check(look.transmission_depth > 0, where, "transmission_depth", look.transmission_depth, "must be above 0");
  check(look.subsurface_radius.minCoeff() > 0, where, "subsurface_radius", look.subsurface_radius.minCoeff(),
        "must be above 0");
  return {.transmission = look.metallic < 1 ? look.transmission : 0,
          .subsurface = look.metallic < 1 ? look.subsurface : 0,
          .depth = look.transmission_depth,
          .radius = look.subsurface_radius,
          .ior = look.ior,
          .alpha = std::max(look.roughness * look.roughness, 1e-4f),
          .is_smooth = look.roughness <= smooth_roughness};
}

Vector3f scattered_share(const Vector3f& color) {
  Vector3f share;
  for (int c = 0; c < 3; ++c) {
    const float a = std::clamp(color[c], 0.0f, 1.0f);
    const float q = 4.09712f + 4.20863f * a - std::sqrt(9.59217f + 41.6808f * a + 17.7126f * a * a);
    share[c] = 1 - std::max(q, 0.0f) * std::max(q, 0.0f);
  }
  return share;
}

Passage pass_through(const RayScene& rays, const Matter& matter, const Vector3f& color, const Ray& incoming,
                     const Hit& hit, const Vector2f& first, PathRandom& random) {
  const Vector3f density = absorption(color, matter.depth);
  Passage passage{.ray = incoming};
  Ray& ray = passage.ray;
  Hit here = hit;
  bool leaves = is_from_inside(rays, ray, here);
  if (leaves) passage.weight = what_is_left(density, here.distance);
  int shells = 1;  // that light is in, where parts of the body reach into each other
  for (int event = 0; event < most_events; ++event) {
    const SurfacePoint point = rays.surface(here, ray.direction, ray.time);
    const Vector2f u = event == 0 ? first : Vector2f(random.next(), random.next());
    const float chance = random.next();
    ray.direction = next_direction(point, ray.direction, matter, leaves, u, chance);
    ray.origin = leave_surface(point, ray.direction);
    if (leaves && ray.direction.dot(point.geometric_normal) < 0) return passage;  // out
    // to the boundary, through the walls between parts
    for (leaves = false; !leaves;) {
      here = rays.intersect(ray);
      if (!here.found()) return passage;
      passage.weight = passage.weight.cwiseProduct(what_is_left(density, here.distance));
      if (here.object != hit.object) {
        // just before it: what follows meets it again
        ray.origin += std::max(0.0f, here.distance * (1 - 1e-4f)) * ray.direction;
        return passage;
      }
      shells += is_from_inside(rays, ray, here) ? -1 : 1;
      leaves = shells <= 0;
      if (!leaves) ray.origin = leave_surface(rays.surface(here, ray.direction, ray.time), ray.direction);
    }
    shells = 1;
    if (!goes_on(passage.weight, random)) return passage;
  }
  ray.origin = leave_surface(rays.surface(here, ray.direction, ray.time), ray.direction);
  return passage;
}

Walk wander(const RayScene& rays, const Matter& matter, const Vector3f& color, const Ray& incoming, const Hit& hit,
            const Vector2f& first, PathRandom& random) {
  const SurfacePoint start = rays.surface(hit, incoming.direction, incoming.time);
  const Frame frame(-start.geometric_normal);
  Ray ray = incoming;
  ray.direction = frame.to_world(cosine_hemisphere(first));
  ray.origin = leave_surface(start, ray.direction);
  Walk walk{.exit = hit, .outwards = -incoming.direction};
  Wanderer wanderer(rays, matter, color, hit.object, random);
  int shells = 1;  // that light is in, where parts of the body reach into each other
  for (int turn = 0; turn < most_turns; ++turn) {
    const Hit met = wanderer.go(ray, walk.weight);
    if (!goes_on(walk.weight, random)) return walk;
    if (!met.found()) {
      ray.origin += ray.max_distance * ray.direction;
      ray.direction = any_direction(random);
      continue;
    }
    shells += is_from_inside(rays, ray, met) ? -1 : 1;
    if (shells <= 0) {
      walk.exit = met;
      walk.outwards = ray.direction;
      return walk;
    }
    ray.origin = leave_surface(rays.surface(met, ray.direction, ray.time), ray.direction);
  }
  return walk;
}

}  // namespace umax
