#include "render/trace/ray_scene.h"

#include <cmath>
#include <limits>
#include <random>

#include "core/base/error.h"
#include "render/scene/sampling.h"
#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

// nearest distance by the textbook formula in double precision over all triangles; negative: nothing
double nearest_by_force(const TriangleMesh& mesh, const Ray& ray) {
  double nearest = -1;
  const Vector3d o = ray.origin.cast<double>(), d = ray.direction.cast<double>();
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Vector3d a = mesh.positions.row(mesh.triangles(t, 0)).transpose();
    const Vector3d e1 = mesh.positions.row(mesh.triangles(t, 1)).transpose() - a;
    const Vector3d e2 = mesh.positions.row(mesh.triangles(t, 2)).transpose() - a;
    const double determinant = e1.dot(d.cross(e2));
    if (std::abs(determinant) < 1e-12) continue;
    const Vector3d s = o - a, q = s.cross(e1);
    const double u = s.dot(d.cross(e2)) / determinant, v = d.dot(q) / determinant, distance = e2.dot(q) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1 && distance > 0 && (nearest < 0 || distance < nearest)) nearest = distance;
  }
  return nearest;
}

TriangleMesh random_triangles(int count) {
  std::mt19937 random(5);
  const auto number = [&] { return double(random()) / double(std::mt19937::max()) * 2 - 1; };
  TriangleMesh mesh;
  mesh.positions.resize(3 * count, 3);
  mesh.triangles.resize(count, 3);
  for (int t = 0; t < count; ++t) {
    const Vector3d middle(3 * number(), 3 * number(), 3 * number());
    for (int c = 0; c < 3; ++c) {
      mesh.positions.row(3 * t + c) =
          (middle + Vector3d(number(), number(), number())).cast<float>().cast<double>().transpose();
      mesh.triangles(t, c) = 3 * t + c;
    }
  }
  return mesh;
}

Vector3f direction_from(const Vector2f& u) {
  const float z = 1 - 2 * u.x(), r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 6.2831853f * u.y();
  return Vector3f(r * std::cos(phi), r * std::sin(phi), z).normalized();
}

}  // namespace

TEST_CASE("rays meet what a loop over all triangles meets") {
  const TriangleMesh mesh = random_triangles(150);
  RenderScene scene;
  scene.objects.push_back(render_object(floor_square(1, -50)));
  scene.objects.push_back(render_object(mesh));
  const RayScene rays(scene);
  const SampleSequence sequence(1024, 2);
  int num_hits = 0, num_different = 0;
  for (unsigned s = 0; s < 1024; ++s) {
    const Vector3f origin = 4 * direction_from(sequence.point(s, 0, 0));
    Ray ray{.origin = origin, .direction = (2 * direction_from(sequence.point(s, 1, 0)) - origin).normalized()};
    const double expected = nearest_by_force(mesh, ray);
    const Hit hit = rays.intersect(ray);
    num_hits += expected > 0;
    if (hit.found() != (expected > 0) || rays.occluded(ray) != hit.found()) {
      ++num_different;  // grazing an edge within rounding
      continue;
    }
    if (!hit.found()) continue;
    CHECK(hit.object == 1);
    CHECK(hit.distance == Approx(expected).epsilon(1e-4));
    const SurfacePoint point = rays.surface(hit, ray.direction);
    CHECK((point.position - (ray.origin + hit.distance * ray.direction)).norm() < 1e-4f);
    CHECK(point.geometric_normal.dot(ray.direction) <= 0);
    ray.max_distance = hit.distance * 0.999f;
    CHECK(nearest_by_force(mesh, ray) > double(ray.max_distance));
    CHECK_FALSE(rays.occluded(ray));
  }
  CHECK(num_hits > 300);
  CHECK(num_different <= 2);
}

TEST_CASE("rays that are traced together meet what they meet alone") {
  RenderScene scene;
  scene.objects.push_back(render_object(floor_square(20, -3)));
  for (int k = 0; k < 10; ++k)  // more objects than there are boxes
    scene.objects.push_back(render_object(moved(random_triangles(20), {0.3 * k, 0.1 * k, 0}, 0.6)));
  const RayScene scene_rays(scene);
  const SampleSequence sequence(2048, 6);
  int num_hits = 0, num_misses = 0, num_different = 0;
  for (unsigned start = 0; start < 2000; start += 100) {
    rows::RayRows rays;
    for (int i = 0; i < 100; ++i) {
      const unsigned s = start + unsigned(i);
      const float reach = s % 3 == 0 ? 2.5f : std::numeric_limits<float>::infinity();
      rays.set(i, {5 * direction_from(sequence.point(s, 0, 0)), direction_from(sequence.point(s, 1, 0)), reach});
    }
    rows::HitRows alone, together;
    rows::RowOf<int> blocked, blocked_together;
    scene_rays.intersect(rays, 100, false, alone);
    scene_rays.intersect(rays, 100, true, together);
    scene_rays.occluded(rays, 100, false, blocked);
    scene_rays.occluded(rays, 100, true, blocked_together);
    for (int i = 0; i < 100; ++i) {
      const Hit hit = scene_rays.intersect(rays.at(i));
      num_hits += hit.found();
      num_misses += !hit.found();
      CHECK(alone.found(i) == hit.found());
      if (hit.found()) CHECK(alone.at(i).distance == hit.distance);
      CHECK(blocked[i] == (scene_rays.occluded(rays.at(i)) ? 1 : 0));
      num_different += together.found(i) != hit.found() || (hit.found() && together.triangle[i] != hit.triangle) ||
                       blocked_together[i] != blocked[i];  // grazing an edge within rounding
    }
  }
  CHECK(num_hits > 500);
  CHECK(num_misses > 500);
  CHECK(num_different <= 2);
}

TEST_CASE("a ray that leaves a surface does not meet it again, whatever the scale") {
  const double scale = GENERATE(0.001, 1.0, 1000.0);
  const bool shifted = GENERATE(false, true);
  const Vector3d shift = shifted ? Vector3d(30 * scale, -7 * scale, 11 * scale) : Vector3d(0, 0, 0);
  RenderScene scene;
  scene.objects.push_back(render_object(moved(unit_sphere(3), shift, scale)));
  const RayScene rays(scene);
  const SampleSequence sequence(2048, 3);
  int num_again = 0;
  for (unsigned s = 0; s < 2048; ++s) {
    const Vector3f from_middle = direction_from(sequence.point(s, 0, 0));
    const Vector3f origin = shift.cast<float>() + 3 * float(scale) * from_middle;
    const Hit hit = rays.intersect({.origin = origin, .direction = -from_middle});
    REQUIRE(hit.found());
    const SurfacePoint point = rays.surface(hit, -from_middle);
    CHECK(point.offset < 1e-3f * float(scale) * (shifted ? 5 : 1));
    const Vector3f out = Frame(point.geometric_normal).to_world(cosine_hemisphere(sequence.point(s, 1, 0)));
    num_again += rays.occluded({.origin = leave_surface(point, out), .direction = out});
    const Hit inside = rays.intersect({.origin = leave_surface(point, -out), .direction = -out});
    num_again += !inside.found() || inside.distance < 1e-3f * float(scale) * out.dot(point.geometric_normal);
  }
  CHECK(num_again == 0);
}

TEST_CASE("normals are interpolated and stand on the viewer's side") {
  RenderScene scene;
  scene.objects.push_back(render_object(unit_sphere(2)));
  const RayScene rays(scene);
  const SampleSequence sequence(256, 3);
  for (unsigned s = 0; s < 256; ++s) {
    const Vector3f from_middle = direction_from(sequence.point(s, 0, 0));
    const Hit outside = rays.intersect({.origin = 2 * from_middle, .direction = -from_middle});
    CHECK(rays.surface(outside, -from_middle).normal.dot(from_middle) > 0.999f);
    CHECK(rays.surface(outside, -from_middle).smooth_position.norm() >=
          rays.surface(outside, -from_middle).position.norm());
    const Hit inside = rays.intersect({.origin = {0, 0, 0}, .direction = from_middle});
    CHECK(rays.surface(inside, from_middle).normal.dot(from_middle) < -0.999f);
  }
}

TEST_CASE("colour comes from the look, the vertices or the texture") {
  TriangleMesh mesh = floor_square(1);
  Look look{.base_color = {0.5f, 0.5f, 0.5f}};
  Vector3f expected = look.base_color;
  SECTION("look") {}
  SECTION("vertices") {
    mesh.colors.resize(4, 3);
    mesh.colors << 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0;
    look.vertex_colors = true;
    expected = {0.5f, 0, 0.5f};  // the middle lies between corners 0 and 2
  }
  SECTION("texture") {
    auto image = std::make_shared<Image>(2, 1);
    image->values = {0, 0.4f, 1, 1, 0, 1};
    look.texture = image;
    mesh.texture_coordinates.resize(6, 2);
    mesh.texture_coordinates << 0.25f, 0.5f, 0.75f, 0.5f, 0.5f, 0.5f, 0.25f, 0.5f, 0.5f, 0.5f, 0.1f, 0.5f;
    expected = 0.5f * Vector3f(0.25f, 0.3f, 1);  // u = 0.375: a quarter of the way from texel to texel
  }
  SECTION("paints of the mesh's materials") {
    auto image = std::make_shared<Image>(1, 1);
    image->values = {0.5f, 1, 1};
    look.paints = {{{1, 0, 0}, nullptr}, {{0.5f, 0.5f, 1}, image}};
    mesh.materials = {1, 1};
    mesh.texture_coordinates.setZero(6, 2);
    expected = {0.25f, 0.5f, 1};
  }
  SECTION("a paint whose texture needs coordinates that the mesh does not have") {
    auto image = std::make_shared<Image>(1, 1);
    look.paints = {{{1, 0, 0}, image}, {{0, 1, 0}, nullptr}};
    mesh.materials = {0, 0};
    expected = {1, 0, 0};
  }
  RenderScene scene;
  scene.objects.push_back(render_object(mesh, look));
  const RayScene rays(scene);
  const Hit hit = rays.intersect({.origin = {0, 1, 0}, .direction = {0, -1, 0}});
  REQUIRE(hit.found());
  CHECK((rays.surface(hit, {0, -1, 0}).base_color - expected).norm() < 1e-4f);
}

TEST_CASE("each triangle has the paint of its material") {
  TriangleMesh mesh = floor_square(1);
  mesh.materials = {0, 1};
  RenderScene scene;
  scene.objects.push_back(render_object(mesh, {.paints = {{{1, 0, 0}, nullptr}, {{0, 0, 1}, nullptr}}}));
  const RayScene rays(scene);
  int seen[2] = {};
  for (const float x : {-0.5f, 0.5f})
    for (const float z : {-0.4f, 0.4f}) {
      const Hit hit = rays.intersect({.origin = {x, 1, z}, .direction = {0, -1, 0}});
      REQUIRE(hit.found());
      const Vector3f color = rays.surface(hit, {0, -1, 0}).base_color;
      CHECK(color == (hit.triangle == 0 ? Vector3f(1, 0, 0) : Vector3f(0, 0, 1)));
      ++seen[hit.triangle];
    }
  CHECK(seen[0] > 0);
  CHECK(seen[1] > 0);
}

TEST_CASE("meshes that cannot be traced are refused by name") {
  RenderScene scene;
  TriangleMesh mesh = floor_square(1);
  SECTION("index out of range") {
    mesh.triangles(1, 2) = 4;
  }
  SECTION("negative index") {
    mesh.triangles(0, 0) = -1;
  }
  SECTION("not a number") {
    mesh.positions(3, 1) = NAN;
  }
  Look look;
  SECTION("a material without a paint") {
    mesh.materials = {0, 2};
    look.paints = {Paint{}, Paint{}};
  }
  scene.objects.push_back(render_object(mesh, look));
  CHECK_THROWS_AS(RayScene(scene), Error);
}

TEST_CASE("an empty scene meets nothing") {
  RenderScene scene;
  CHECK_FALSE(RayScene(scene).intersect({}).found());
  scene.objects.push_back(render_object(TriangleMesh{}));
  CHECK_FALSE(RayScene(scene).occluded({}));
}
