#include "render/trace/moving_clusters.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "render/trace/ray_scene.h"
#include "tests/render/cluster_meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::test;

namespace {

std::shared_ptr<const TriangleMesh> shared(TriangleMesh mesh) {
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

// turns, goes along and shakes; positions as single precision has them
SurfaceMotion motion_of(const TriangleMesh& mesh, int instants, float first, float last, Numbers& number) {
  SurfaceMotion motion;
  motion.first = first;
  motion.last = last;
  for (int k = 0; k < instants; ++k) {
    TriangleMesh there = mesh;
    const Eigen::AngleAxisd turn(0.4 * k, Vector3d(0.3, 1, 0.2).normalized());
    there.positions = (mesh.positions * turn.toRotationMatrix().transpose()).rowwise() +
                      (0.3 * k * Vector3d(1, 0.4, -0.2)).transpose();
    for (Eigen::Index i = 0; i < there.num_vertices(); ++i)
      there.positions.row(i) += 0.02 * number.vector().transpose();
    there.positions = there.positions.cast<float>().cast<double>().eval();
    motion.instants.push_back(shared(std::move(there)));
  }
  return motion;
}

RenderObject moving(TriangleMesh mesh, int instants, float first, float last, unsigned seed) {
  Numbers number(seed);
  RenderObject object = render_object(std::move(mesh));
  object.motion = motion_of(*object.mesh, instants, first, last, number);
  return object;
}

Points positions_at(const RenderObject& object, float time) {
  const SurfaceMotion& motion = object.motion;
  if (motion.instants.empty()) return object.mesh->positions;
  const double segments = double(motion.instants.size()) - 1;
  const double place =
      std::clamp((double(time) - double(motion.first)) / double(motion.last - motion.first), 0.0, 1.0) * segments;
  const std::size_t before = std::min(std::size_t(place), motion.instants.size() - 2);
  const double share = place - double(before);
  return (1 - share) * motion.instants[before]->positions + share * motion.instants[before + 1]->positions;
}

// by the textbook's formula in double precision, over all triangles; the distance to the edge says how sure it is
struct Expected {
  Hit hit;
  double distance = std::numeric_limits<double>::infinity(), edge = 1;
};
Expected nearest_by_force(const std::vector<RenderObject>& objects, const Ray& ray) {
  Expected nearest;
  const Vector3d o = ray.origin.cast<double>(), d = ray.direction.cast<double>();
  for (unsigned n = 0; n < objects.size(); ++n) {
    const Points positions = positions_at(objects[n], ray.time);
    for (Eigen::Index t = 0; t < objects[n].mesh->num_triangles(); ++t) {
      const auto corner = [&](int c) -> Vector3d {
        return positions.row(objects[n].mesh->triangles(t, c)).transpose();
      };
      const Vector3d a = corner(0), e1 = corner(1) - a, e2 = corner(2) - a;
      const double determinant = e1.dot(d.cross(e2));
      if (std::abs(determinant) < 1e-12) continue;
      const Vector3d s = o - a, q = s.cross(e1);
      const double u = s.dot(d.cross(e2)) / determinant, v = d.dot(q) / determinant, far = e2.dot(q) / determinant;
      const double edge = std::min({u, v, 1 - u - v});
      if (far > 0 && far <= double(ray.max_distance)) nearest.edge = std::min(nearest.edge, std::abs(edge));
      if (edge < 0 || !(far > 0 && far <= double(ray.max_distance)) || far >= nearest.distance) continue;
      nearest.distance = far;
      nearest.hit = {.object = n, .triangle = unsigned(t), .distance = float(far), .u = float(u), .v = float(v)};
    }
  }
  return nearest;
}

Ray random_ray(Numbers& number) {
  Ray ray;
  ray.origin = (5 * number.vector().normalized()).cast<float>();
  ray.direction = (1.5 * number.vector() - ray.origin.cast<double>()).normalized().cast<float>();
  ray.time = float(number() * 0.5 + 0.5) * 0.9999999f;
  ray.max_distance = number() > 0.5 ? 5.0f : std::numeric_limits<float>::infinity();
  return ray;
}

bool is_same(const Hit& a, const Hit& b) {
  if (!a.found() || !b.found()) return a.found() == b.found();
  return a.object == b.object && a.triangle == b.triangle && a.distance == b.distance && a.u == b.u && a.v == b.v;
}

}  // namespace

TEST_CASE("rays meet of what moves what a loop over all triangles at their time meets") {
  const int instants = GENERATE(2, 3, 4, 9);
  const bool reaches_beyond = GENERATE(false, true);
  const float first = reaches_beyond ? -1.5f : 0, last = reaches_beyond ? 2.5f : 1;
  Numbers number(7);
  RenderScene scene;
  scene.objects.push_back(moving(soup(40, number), instants, first, last, 1));
  scene.objects.push_back(render_object(soup(20, number)));
  scene.objects.push_back(moving(sheet(12), instants, first, last, 2));
  scene.objects.push_back(moving(unit_sphere(2), 3, 0.2f, 0.7f, 3));  // rests at first and at last
  const RayScene rays(scene);
  int num_hits = 0, num_unsure = 0;
  for (int k = 0; k < 1500; ++k) {
    const Ray ray = random_ray(number);
    const Expected expected = nearest_by_force(scene.objects, ray);
    const Hit hit = rays.intersect(ray);
    if (expected.edge < 1e-5) {
      ++num_unsure;
      continue;
    }
    CAPTURE(k, instants, reaches_beyond);
    REQUIRE(hit.found() == expected.hit.found());
    CHECK(rays.occluded(ray) == hit.found());
    if (!hit.found()) continue;
    ++num_hits;
    CHECK(hit.object == expected.hit.object);
    CHECK(hit.triangle == expected.hit.triangle);
    CHECK(hit.distance == Approx(expected.distance).epsilon(1e-4));
    CHECK(hit.u == Approx(expected.hit.u).margin(2e-3));
    CHECK(hit.v == Approx(expected.hit.v).margin(2e-3));
    const SurfacePoint point = rays.surface(hit, ray.direction, ray.time);
    CHECK((point.position - (ray.origin + hit.distance * ray.direction)).norm() < 1e-4f);
  }
  CHECK(num_hits > 500);
  CHECK(num_unsure < 60);
}

TEST_CASE("what moves is met the same alone and together, however its hierarchy is built") {
  RenderScene scene;
  scene.objects.push_back(moving(sheet(20), 3, -1.5f, 2.5f, 4));
  scene.objects.push_back(moving(unit_sphere(3), 2, 0, 1, 5));
  scene.objects.push_back(render_object(moved(unit_sphere(2), {1, 1, 1})));
  ClusterCache cache;
  const RayScene good(scene), fast(scene, HierarchyBuild::fast, &cache), cached(scene, HierarchyBuild::good, &cache);
  Numbers number(11);
  int num_hits = 0, num_different = 0;
  for (int k = 0; k < 40; ++k) {
    rows::RayRows rays;
    for (int i = 0; i < 100; ++i) rays.set(i, random_ray(number));
    rows::HitRows together, apart;
    rows::RowOf<int> blocked, blocked_together;
    good.intersect(rays, 100, true, together);
    good.intersect(rays, 100, false, apart);
    good.occluded(rays, 100, false, blocked);
    good.occluded(rays, 100, true, blocked_together);
    for (int i = 0; i < 100; ++i) {
      const Hit hit = good.intersect(rays.at(i));
      num_hits += hit.found();
      CHECK(apart.found(i) == hit.found());
      CHECK(blocked[i] == (hit.found() ? 1 : 0));
      CHECK(blocked_together[i] == blocked[i]);
      CHECK(is_same(hit, cached.intersect(rays.at(i))));
      num_different += !is_same(hit, fast.intersect(rays.at(i))) ||
                       (hit.found() ? !is_same(hit, together.at(i)) : together.found(i));  // on an edge
    }
  }
  CHECK(num_hits > 1000);
  CHECK(num_different <= 2);
}

TEST_CASE("a closed surface that moves has no holes: not at its edges and not at its corners") {
  const double scale = GENERATE(1e-3, 1.0, 1e3);
  TriangleMesh mesh = unit_sphere(3);
  mesh.positions *= scale;
  RenderScene scene;
  scene.objects.push_back(render_object(mesh));
  for (const double x : {0.0, 0.3, 0.4}) {
    TriangleMesh there = mesh;
    there.positions *= 1 + x;
    there.positions.rowwise() += (x * scale * Vector3d(0.5, -0.4, 0.3)).transpose();
    scene.objects[0].motion.instants.push_back(shared(there));
  }
  const RayScene rays(scene);
  const TracedObject object = make_traced_object(scene.objects[0]);
  Numbers number(13);
  int num_missed = 0, num_unfinished = 0;
  for (std::size_t k = 0; k < 30 * object.triangles.size(); ++k) {
    const std::size_t t = k % object.triangles.size();
    const float time = float(0.5 + 0.4999 * number());
    const TracedObject::Instant instant = object.at(time);
    const auto corner = [&](int c) -> Vector3f {
      const unsigned index = object.triangles[t].index[c];
      return (1 - instant.share) * Vector3f(object.vertices[instant.before + index].position) +
             instant.share * Vector3f(object.vertices[instant.after + index].position);
    };
    const Vector3f origin = 0.2f * float(scale) * number.vector().cast<float>();
    for (const Vector3f& target :
         {corner(0), Vector3f((corner(0) + corner(1)) / 2), Vector3f(0.9f * corner(1) + 0.1f * corner(2)),
          Vector3f((corner(0) + corner(1) + corner(2)) / 3)}) {
      const Ray ray{.origin = origin, .direction = (target - origin).normalized(), .time = time};
      const Hit hit = rays.intersect(ray);
      num_missed += !hit.found() + !rays.occluded(ray);
      if (hit.found()) num_unfinished += !(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1.00001f && hit.distance > 0);
    }
  }
  CHECK(num_missed == 0);
  CHECK(num_unfinished == 0);
}

TEST_CASE("rays along an axis, in a face's plane and against triangles without area meet nothing that is no number") {
  TriangleMesh mesh = sheet(4);
  mesh.positions.col(2).setZero();
  mesh.triangles.row(0) << 3, 3, 3;
  mesh.triangles.row(1) << 0, 1, 2;  // in one line
  RenderScene scene;
  scene.objects.push_back(render_object(mesh));
  scene.objects[0].motion.instants = {scene.objects[0].mesh, scene.objects[0].mesh};
  const RayScene rays(scene);
  Numbers number(17);
  const Vector3f directions[] = {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {-0.0f, 0.0f, -1}, {0.6f, 0.8f, 0}};
  for (int k = 0; k < 200; ++k) {
    const Vector3f origin = (k % 2 ? 1.9 * number.vector() : Vector3d(2 * number(), 2 * number(), 0)).cast<float>();
    for (const Vector3f& direction : directions) {
      const Hit hit = rays.intersect({.origin = origin, .direction = direction, .time = 0.5f});
      if (!hit.found()) continue;
      CHECK(hit.triangle > 1);
      CHECK((std::isfinite(hit.distance) && hit.distance > 0));
      CHECK((hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1.00001f));
    }
  }
  const Hit below = rays.intersect({.origin = {1.1f, 0.7f, 3}, .direction = {0, 0, -1}, .time = 0.25f});
  REQUIRE(below.found());
  CHECK(below.distance == 3);
  CHECK_FALSE(
      rays.occluded({.origin = {1.1f, 0.7f, 3}, .direction = {0, 0, -1}, .max_distance = 2.99f, .time = 0.25f}));
  CHECK(rays.intersect({.origin = {1.1f, 0.7f, -3}, .direction = {0, 0, 1}, .time = 0.25f}).found());
}

TEST_CASE("boxes hold their clusters at all times") {
  const int instants = GENERATE(2, 3, 4, 8, 13);
  const RenderObject shape =
      GENERATE(false, true) ? moving(sheet(9), 13, -0.3f, 1.2f, 6) : moving(sheet(9), 13, 0, 1, 6);
  RenderObject cut = shape;
  cut.motion.instants.resize(std::size_t(instants));
  const TracedObject object = make_traced_object(cut);
  const auto clusters = std::make_shared<const TriangleClusters>(make_clusters(object.triangles, object.num_vertices));
  const MovingClusters moving_clusters(object, clusters);
  const std::size_t steps = moving_clusters.num_steps();
  for (int k = 0; k <= 60; ++k) {
    const float time = float(k) / 60, place = time * float(steps - 1);
    const std::size_t step = std::min(std::size_t(place), steps - 2);
    const float share = place - float(step);
    const Points positions = positions_at(cut, time);
    for (std::size_t i = 0; i < clusters->size(); ++i) {
      const auto &before = moving_clusters.box(i, step), &after = moving_clusters.box(i, step + 1);
      for (const unsigned vertex : (*clusters)[i].vertices)
        for (int c = 0; c < 3; ++c) {
          const float x = float(positions(vertex, c));
          CHECK((1 - share) * before.low[c] + share * after.low[c] <= x);
          CHECK((1 - share) * before.high[c] + share * after.high[c] >= x);
        }
    }
  }
}

TEST_CASE("a ray comes through few boxes of long thin triangles, at rest and on their way, and meets the right one") {
  constexpr int count = 15000, num_rays = 60;
  const Vector3d way = GENERATE(Vector3d(0, 0, 0), Vector3d(0.3, -0.1, 0.2));
  RenderScene scene;
  scene.objects.push_back(render_object(fan(count)));
  if (!way.isZero()) {
    TriangleMesh there = fan(count);
    there.positions.rowwise() += way.transpose();
    scene.objects[0].motion.instants = {scene.objects[0].mesh, shared(std::move(there))};
  }
  const TracedObject object = make_traced_object(scene.objects[0]);
  REQUIRE(is_sliced(object));
  const MovingClusters clusters(
      object, std::make_shared<const TriangleClusters>(make_clusters(object.triangles, object.num_vertices)));
  const RayScene rays(scene);
  Numbers number(19);
  int num_boxes = 0;
  for (int k = 0; k < num_rays; ++k) {
    const float time = k % 2 ? 0.999f : 0.0f;
    const Vector3d place(0.4 * number(), 0.4 * number(), 0), own = place - double(time) * way;
    const Ray ray{.origin = (place + Vector3d(0, 0, 3)).cast<float>(), .direction = {0, 0, -1}, .time = time};
    const Hit hit = rays.intersect(ray);
    REQUIRE(hit.found());
    CHECK(rays.occluded(ray));
    CHECK(hit.distance == Approx(3 - double(time) * way[2] - 0.5 * own[0]).epsilon(1e-5));
    const double angle = std::atan2(own[1], own[0]) / (2 * std::numbers::pi);
    CHECK(std::remainder(double(hit.triangle) + 0.5 - angle * count, count) == Approx(0).margin(0.6));
    const std::size_t step = time > 0 ? clusters.num_steps() - 1 : 0;
    for (std::size_t i = 0; i < clusters.count(); ++i) {
      const MovingClusters::Box& box = clusters.box(i, step);
      num_boxes += box.low[0] <= ray.origin[0] && ray.origin[0] <= box.high[0] && box.low[1] <= ray.origin[1] &&
                   ray.origin[1] <= box.high[1];
    }
  }
  CHECK(num_boxes < 50 * num_rays);  // of whole clusters 150 and more, of triangles 2,000
}
