#include "render/trace/moving_clusters.h"

#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "render/scene/sampling.h"
#include "render/trace/ray_scene.h"
#include "tests/support/catch.h"
#include "tests/support/render_shapes.h"

using namespace umax;
using namespace umax::test;

namespace {

class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  double operator()() { return double(random_()) / double(std::mt19937::max()) * 2 - 1; }  // -1 .. 1
  Vector3d vector() {
    const double x = (*this)(), y = (*this)(), z = (*this)();
    return {x, y, z};
  }

 private:
  std::mt19937 random_;
};

std::shared_ptr<const TriangleMesh> shared(TriangleMesh mesh) {
  return std::make_shared<const TriangleMesh>(std::move(mesh));
}

TriangleMesh soup(int count, Numbers& number) {
  TriangleMesh mesh;
  mesh.positions.resize(3 * count, 3);
  mesh.triangles.resize(count, 3);
  for (int t = 0; t < count; ++t) {
    const Vector3d middle = 2 * number.vector();
    for (int c = 0; c < 3; ++c) {
      mesh.positions.row(3 * t + c) = (middle + number.vector()).transpose();
      mesh.triangles(t, c) = 3 * t + c;
    }
  }
  return mesh;
}

// an open sheet in waves
TriangleMesh sheet(int cells) {
  TriangleMesh mesh;
  mesh.positions.resize((cells + 1) * (cells + 1), 3);
  mesh.triangles.resize(2 * cells * cells, 3);
  const auto node = [&](int i, int j) { return i * (cells + 1) + j; };
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const double x = 4.0 * i / cells - 2, y = 4.0 * j / cells - 2;
      mesh.positions.row(node(i, j)) << x, y, 0.3 * std::sin(3 * x) * std::cos(2 * y);
    }
  for (int i = 0, t = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      mesh.triangles.row(t++) << node(i, j), node(i + 1, j), node(i + 1, j + 1);
      mesh.triangles.row(t++) << node(i, j), node(i + 1, j + 1), node(i, j + 1);
    }
  return mesh;
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

TracedObject traced(const TriangleMesh& mesh) {
  return make_traced_object(render_object(mesh));
}

}  // namespace

TEST_CASE("every triangle is in one cluster, and clusters are well filled where triangles share vertices") {
  const TracedObject object = traced(GENERATE(unit_sphere(5), sheet(40)));
  const TriangleClusters clusters = make_clusters(object.triangles, object.num_vertices);
  std::vector<int> seen(object.triangles.size(), 0);
  for (const TriangleCluster& cluster : clusters) {
    std::set<unsigned> own;
    for (int i = 0; i < cluster_size; ++i) {
      own.insert(cluster.triangles[i]);
      for (int c = 0; c < 3; ++c)
        CHECK(cluster.vertices[cluster.corners.places[c][i]] == object.triangles[cluster.triangles[i]].index[c]);
    }
    for (const unsigned triangle : own) ++seen[triangle];
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int count) { return count == 1; }));
  CHECK(double(object.triangles.size()) / double(clusters.size()) > 14);
}

TEST_CASE("clusters of meshes that fall apart, turn back and have corners twice hold all triangles, too") {
  TriangleMesh mesh = sheet(3);
  mesh.triangles.row(2) << 5, 5, 5;
  mesh.triangles.row(3) << 1, 1, 2;
  mesh.triangles.row(4) = mesh.triangles.row(5);
  SECTION("as it is") {}
  SECTION("no two triangles share a vertex") {
    Numbers number(3);
    mesh = soup(50, number);
  }
  SECTION("a fan of more triangles than a cluster has room for") {
    mesh.triangles.resize(100, 3);
    for (int t = 0; t < 100; ++t) mesh.triangles.row(t) << 0, 1 + t % 10, 2 + t % 10;
  }
  SECTION("nothing") {
    mesh.triangles.resize(0, 3);
  }
  const TracedObject object = traced(mesh);
  std::multiset<unsigned> seen;
  for (const TriangleCluster& cluster : make_clusters(object.triangles, object.num_vertices)) {
    const std::set<unsigned> own(cluster.triangles.begin(), cluster.triangles.end());
    seen.insert(own.begin(), own.end());
    for (const unsigned vertex : cluster.vertices) CHECK(vertex < object.num_vertices);
  }
  CHECK(seen.size() == object.triangles.size());
  CHECK(std::set<unsigned>(seen.begin(), seen.end()).size() == object.triangles.size());
}

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

TEST_CASE("a mesh that is known has its clusters already, another one gets its own") {
  const TracedObject sphere = traced(unit_sphere(3)), other = traced(sheet(10));
  TracedObject turned = sphere;
  std::swap(turned.triangles[0], turned.triangles[1]);
  ClusterCache cache;
  const auto first = cache.clusters_of(sphere);
  CHECK(cache.clusters_of(other) != first);
  CHECK(cache.clusters_of(turned) != first);
  CHECK(cache.clusters_of(sphere) == first);
}
