// How triangles are grouped for what moves.
#include "render/trace/triangle_clusters.h"

#include <algorithm>
#include <ctime>
#include <set>
#include <vector>

#include "tests/render/cluster_meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::test;

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

TEST_CASE("many triangles at one vertex are grouped in little time, with their neighbours") {
  const int count = 40000;
  const TracedObject object = traced(fan(count));
  const std::clock_t start = std::clock();
  const TriangleClusters clusters = make_clusters(object.triangles, object.num_vertices);
  CHECK(double(std::clock() - start) / CLOCKS_PER_SEC < 2);  // 0.02, where to look at all each time took 5
  int num_apart = 0;
  std::size_t num_triangles = 0;
  for (const TriangleCluster& cluster : clusters) {
    const std::set<unsigned> own(cluster.triangles.begin(), cluster.triangles.end());
    num_triangles += own.size();
    num_apart += *own.rbegin() - *own.begin() >= own.size();
  }
  CHECK(num_triangles == std::size_t(count));
  CHECK(count / double(clusters.size()) > 13);
  CHECK(num_apart <= 1);  // where the last meets the first
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
