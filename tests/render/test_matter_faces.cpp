// What a face of clear matter does to a path: Snell, Fresnel, the slopes of its facets.
#include <algorithm>
#include <cmath>
#include <vector>

#include "render/trace/matter.h"
#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"
#include "tests/support/test_scene.h"

using namespace umax;
using namespace umax::test;

namespace {

/// Share of light inside that the facets of a GGX face throw back, of those that it sees: over their slopes, which are as
/// frequent as alpha^2 / (pi (alpha^2 + x^2 + y^2)^2).
double thrown_back_inside(double cosine, double alpha, double ior) {
  const double sine = std::sqrt(1 - cosine * cosine);
  double back = 0, all = 0;
  constexpr int n = 400;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      // slope by its distribution: u = r^2 / (alpha^2 + r^2)
      const double u = (i + 0.5) / n, r = alpha * std::sqrt(u / (1 - u)), angle = 2 * 3.14159265358979 * (j + 0.5) / n;
      const double seen = cosine - r * std::cos(angle) * sine;  // its area as the light sees it
      if (!(seen > 0)) continue;
      const double c = seen / std::sqrt(1 + r * r), beyond2 = 1 - (1 - c * c) * ior * ior;
      double fresnel = 1;
      if (beyond2 > 0) {
        const double t = std::sqrt(beyond2), p = (c - ior * t) / (c + ior * t), s = (ior * c - t) / (ior * c + t);
        fresnel = 0.5 * (p * p + s * s);
      }
      back += seen * fresnel;
      all += seen;
    }
  return back / all;
}

}  // namespace

TEST_CASE("light is bent at a face as Snell says, and thrown back inside beyond the critical angle") {
  Look look;
  look.roughness = 0;
  look.transmission = 1;
  look.ior = GENERATE(1.2f, 1.5f, 2.4f);
  RenderScene scene;
  scene.objects.push_back(render_object(slab(50, 1), look));
  const RayScene rays(scene);
  const Matter matter = make_matter(look, "slab");
  PathRandom random(1, 2, 3);
  for (const float degrees : {0.0f, 20.0f, 60.0f, 85.0f}) {
    const float angle = degrees * 3.14159265f / 180;
    const Ray ray{.origin = {0, 0, 1}, .direction = {std::sin(angle), 0, -std::cos(angle)}};
    const Hit hit = rays.intersect(ray);
    // through both parallel faces: as it came, shifted by what the angle inside makes
    Passage way = pass_through(rays, matter, {1, 1, 1}, ray, hit, {0.3f, 0.7f}, random);
    while (way.ray.direction.z() > 0) way = pass_through(rays, matter, {1, 1, 1}, ray, hit, {0.3f, 0.7f}, random);
    CHECK((way.ray.direction - ray.direction).norm() < 2e-3f);
    if (way.ray.origin.z() > -0.51f && way.ray.origin.x() < 6) {
      const double inside = std::asin(std::sin(double(angle)) / double(look.ior));
      const double crossings =
          std::round(((double(way.ray.origin.x()) - 0.5 * std::tan(double(angle))) / std::tan(inside) - 1) / 2);
      if (degrees > 0)
        CHECK(double(way.ray.origin.x()) ==
              Approx(0.5 * std::tan(double(angle)) + (2 * crossings + 1) * std::tan(inside)).margin(0.01));
    }
  }
  // from inside, more slanted than the critical angle: it stays inside for as long as it is followed along the slab
  const float beyond = std::asin(1 / look.ior) + 0.02f;
  const Ray inside{.origin = {0, 0, 0}, .direction = {std::sin(beyond), 0, std::cos(beyond)}};
  const Passage kept = pass_through(rays, matter, {1, 1, 1}, inside, rays.intersect(inside), {0.5f, 0.5f}, random);
  CHECK(kept.ray.origin.x() > std::min(40.0f, 50 * std::tan(beyond)));
}

TEST_CASE("a rough face spreads light as the slopes of its facets say") {
  // half of the facets of a GGX face have a slope below alpha
  Look look;
  look.roughness = GENERATE(0.2f, 0.35f, 0.6f);
  look.transmission = 1;
  RenderScene scene;
  scene.objects.push_back(render_object(slab(50, 1), look));
  const RayScene rays(scene);
  const Matter matter = make_matter(look, "slab");
  PathRandom random(1, 2, 3);
  const Ray ray{.origin = {0, 0, 1}, .direction = {0, 0, -1}};
  std::vector<double> tangents;
  for (int i = 0; i < 4001; ++i) {
    const Passage way =
        pass_through(rays, matter, {1, 1, 1}, ray, rays.intersect(ray), {random.next(), random.next()}, random);
    if (way.ray.origin.z() < 0) tangents.push_back(std::hypot(double(way.ray.origin.x()), double(way.ray.origin.y())));
  }
  std::nth_element(tangents.begin(), tangents.begin() + std::ptrdiff_t(tangents.size() / 2), tangents.end());
  const double facet = std::atan(double(matter.alpha)), inside = std::asin(std::sin(facet) / double(look.ior));
  CHECK(tangents.size() > 3600);
  CHECK(tangents[tangents.size() / 2] == Approx(std::tan(facet - inside)).epsilon(0.06));
}

TEST_CASE("a rough face throws back inside what Fresnel says for each of its facets") {
  // near the critical angle, where this is not what he says for the face as a whole
  const float sine = GENERATE(0.5f, 0.62f, 0.7f, 0.8f);
  Look look;
  look.roughness = 0.35f;
  look.transmission = 1;
  look.transmission_depth = 0.2f;  // what is thrown back does not get out of the slab again
  RenderScene scene;
  scene.objects.push_back(render_object(slab(50, 10), look));
  const RayScene rays(scene);
  const Matter matter = make_matter(look, "slab");
  PathRandom random(1, 2, 3);
  const double cosine = std::sqrt(1 - double(sine) * double(sine));
  const Ray ray{.origin = {0, 0, 5 - 1e-4f}, .direction = {sine, 0, float(cosine)}};
  constexpr int paths = 8000;
  double out = 0;
  for (int i = 0; i < paths; ++i)
    out += double(pass_through(rays, matter, {0.1f, 0.1f, 0.1f}, ray, rays.intersect(ray),
                               {random.next(), random.next()}, random)
                      .weight.x()) /
           paths;
  CHECK(1 - out == Approx(thrown_back_inside(cosine, double(matter.alpha), double(look.ior))).margin(0.02));
}
