// A ray against the triangles of a moving cluster, all of them at once: watertight [Woop, Benthin, Wald 2013,
// "Watertight Ray/Triangle Intersection"]. Corners are moved so that the ray starts at zero and sheared so that it runs
// along one axis; what an edge says of the ray is exactly opposite for its other triangle.
#pragma once

namespace umax {

constexpr int cluster_size = 16;  // triangles, and vertices, at most

/// Vertices of a cluster at one instant: x of all, y of all, z of all [m].
struct alignas(64) ClusterPositions {
  float of_axis[3][cluster_size];
};

/// Of each triangle's corners, the places among the cluster's vertices.
struct alignas(64) ClusterCorners {
  unsigned char places[3][cluster_size];
};

/// A ray as the test needs it: made once for many clusters.
struct ShearedRay {
  int x, y, z;  // axes, z: that along which it runs most
  float origin[3], shear[3];
};
ShearedRay shear(const float origin[3], const float direction[3]);

struct ClusterHit {
  int triangle = -1;  // its place in the cluster; less: none
  float distance = 0, u = 0, v = 0;
  bool found() const { return triangle >= 0; }
};

/// The nearest beyond 0 and up to `most`, of equal ones the first. share: of the instant after.
ClusterHit hit_cluster(const ShearedRay& ray, float most, const ClusterPositions& before, const ClusterPositions& after,
                       float share, const ClusterCorners& corners);

}  // namespace umax
