#include "tools/setup/pin_bones.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/model/rest_surface.h"
#include "embedding/embedding.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/mesh_report.h"
#include "embedding/surface/topology.h"

namespace umax {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double spacing = 0.5;       // [cells] of points on bones, and between their surfaces
constexpr double least_depth = 0.05;  // [cells] of points between surfaces: nearer ones are on them already
constexpr double largest_share = 8;   // [-] sum of a point's shares without their signs: needles would magnify rounding
constexpr Eigen::Index in_block = 64;  // hexes

// the bones at rest, and which of their connected parts a vertex belongs to
struct Bones {
  TriangleMesh mesh;  // world [m]
  std::vector<int> part_of_triangle, part_of_vertex;
  bool is_closed = false;
};

Bones bones_of(TriangleMesh mesh) {
  Bones bones{.mesh = std::move(mesh), .part_of_triangle = {}, .part_of_vertex = {}};
  const std::vector<int> welded = weld(bones.mesh.positions);
  bones.part_of_triangle = triangle_components(bones.mesh.triangles, welded).first;
  bones.part_of_vertex.assign(std::size_t(bones.mesh.num_vertices()), -1);
  for (Eigen::Index t = 0; t < bones.mesh.num_triangles(); ++t)
    for (const int v : bones.mesh.triangles.row(t))
      for (const int same : {v, welded[std::size_t(v)]})
        bones.part_of_vertex[std::size_t(same)] = bones.part_of_triangle[std::size_t(t)];
  bones.is_closed = report_mesh(bones.mesh).watertight;
  return bones;
}

// the triangles of each part counter-clockwise from outside
Triangles turned_outwards(const Bones& bones) {
  const Points& x = bones.mesh.positions;
  Triangles triangles = bones.mesh.triangles;
  std::vector<double> volumes(bones.part_of_triangle.size(), 0);
  const auto volume_of = [&](Eigen::Index t) -> double& {
    return volumes[std::size_t(bones.part_of_triangle[std::size_t(t)])];
  };
  const Eigen::RowVector3d middle = x.colwise().mean();
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    volume_of(t) +=
        (x.row(triangles(t, 0)) - middle).dot((x.row(triangles(t, 1)) - middle).cross(x.row(triangles(t, 2)) - middle));
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    if (volume_of(t) < 0) std::swap(triangles(t, 1), triangles(t, 2));
  return triangles;
}

// a point of the pin, before it is known whether a hex holds it
struct Rider {
  Vector3d rest;  // [m]
  std::array<int, 3> corners;
  Vector3d shares;
  int part = 0;
};

// the vertices of triangles, and points on these as dense as cells need
std::vector<Rider> riders_on(const Bones& bones, double cell) {
  const TriangleMesh& mesh = bones.mesh;
  std::vector<Rider> riders;
  std::vector<char> taken(std::size_t(mesh.num_vertices()), 0);
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const std::array<int, 3> corners{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
    Matrix3d places;
    for (int k = 0; k < 3; ++k) places.col(k) = mesh.positions.row(corners[std::size_t(k)]).transpose();
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (places.col(k) - places.col((k + 1) % 3)).norm());
    const int parts = int(std::ceil(longest / (spacing * cell)));
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; i + j <= parts; ++j) {
        const Vector3d shares = Vector3d(i, j, parts - i - j) / parts;
        Eigen::Index corner = 0;
        if (shares.maxCoeff(&corner) == 1 && std::exchange(taken[std::size_t(corners[std::size_t(corner)])], 1))
          continue;
        riders.push_back({places * shares, corners, shares, bones.part_of_triangle[std::size_t(t)]});
      }
  }
  return riders;
}

// Those that a hex holds. Throws where none is.
std::vector<Rider> inside_of(const Lattice& lattice, std::vector<Rider> riders, const MeshSource& source,
                             std::vector<std::string>& warnings, const std::string& pin) {
  Points places(Eigen::Index(riders.size()), 3);
  for (std::size_t i = 0; i < riders.size(); ++i) places.row(Eigen::Index(i)) = riders[i].rest.transpose();
  const VectorXi hex = find_hexes(places, lattice);
  std::vector<Rider> held;
  for (std::size_t i = 0; i < riders.size(); ++i)
    if (hex[Eigen::Index(i)] >= 0) held.push_back(riders[i]);
  if (held.empty()) embed_points(places, lattice, "inside: point");
  if (held.size() < riders.size())
    warnings.push_back(
        fmt::format("pin.{}: {} of {} points on {} lie outside of the body's cage: the pin holds what of "
                    "the body is inside of the others",
                    pin, riders.size() - held.size(), riders.size(), source.path.filename().string()));
  return held;
}

// Of the same part the nearest vertex that lies at least as deep below the triangle; -1: none.
int vertex_across(const Bones& bones, const RestSurface& surface, const SurfaceHit& hit, const Vector3d& point) {
  const Vector3d from = corner_of(surface, hit.triangle, 0), out = surface.triangle_normals.row(hit.triangle);
  const int part = bones.part_of_vertex[std::size_t(surface.triangles(hit.triangle, 0))];
  int across = -1;
  double nearest = infinity;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
    if (bones.part_of_vertex[std::size_t(v)] != part) continue;
    const Vector3d place = surface.vertices.row(v).transpose();
    const double far = (place - point).squaredNorm();
    if (far < nearest && (from - place).dot(out) >= -hit.distance) nearest = far, across = int(v);
  }
  return across;
}

std::optional<InnerPoint> inner_point(const Bones& bones, const RestSurface& surface, const SurfaceHit& hit,
                                      const Vector3d& point) {
  InnerPoint inner;
  inner.corners[3] = vertex_across(bones, surface, hit, point);
  if (inner.corners[3] < 0) return std::nullopt;
  const Vector3d first = corner_of(surface, hit.triangle, 0);
  for (int k = 0; k < 3; ++k) inner.corners[std::size_t(k)] = surface.triangles(hit.triangle, k);
  Matrix3d edges;
  for (int k = 1; k < 4; ++k)
    edges.col(k - 1) = surface.vertices.row(inner.corners[std::size_t(k)]).transpose() - first;
  const Vector3d along = edges.inverse() * (point - first);
  inner.shares << 1 - along.sum(), along;
  if (!(inner.shares.lpNorm<1>() <= largest_share)) return std::nullopt;
  return inner;
}

struct InnerRider {
  Rider rider;
  InnerPoint inner;
};

// Eight points of each hex, where they are between the surfaces of closed bones.
std::vector<InnerRider> riders_in(const Bones& bones, const Lattice& lattice) {
  if (!bones.is_closed) return {};
  const RestSurface surface = make_rest_surface(bones.mesh.positions, turned_outwards(bones));
  if (surface.nodes.empty()) return {};
  const double shallow = least_depth * cell_of(lattice);
  std::vector<std::vector<InnerRider>> of_hex(std::size_t(lattice.num_hexes()));
  parallel_blocks(lattice.num_hexes(), in_block, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index e = first; e < last; ++e)
      for (int n = 0; n < 8; ++n) {
        const Vector3d s = spacing * Vector3d(n & 4 ? 1 : -1, n & 2 ? 1 : -1, n & 1 ? 1 : -1);
        const Vector3d point = rest_nodes(lattice, e).transpose() * shape_functions(s);
        if (!surface.box.contains(point)) continue;
        const SurfaceHit hit = nearest_point(surface, point, infinity);
        if (hit.triangle < 0 || hit.distance > -shallow) continue;
        const std::optional<InnerPoint> inner = inner_point(bones, surface, hit, point);
        if (!inner) continue;
        const int part = bones.part_of_vertex[std::size_t(inner->corners[0])];
        of_hex[std::size_t(e)].push_back({{point, {}, Vector3d(1, 0, 0), part}, *inner});
      }
  });
  std::vector<InnerRider> riders;
  for (const auto& some : of_hex) riders.insert(riders.end(), some.begin(), some.end());
  return riders;
}

void give_points(const std::vector<Rider>& riders, const Lattice& lattice, Pin& pin) {
  const auto count = Eigen::Index(riders.size());
  pin.rest.resize(count, 3);
  pin.motion.corners.resize(count, 3);
  pin.motion.shares.resize(count, 3);
  pin.part.resize(count);
  for (Eigen::Index p = 0; p < count; ++p) {
    const Rider& rider = riders[std::size_t(p)];
    pin.rest.row(p) = rider.rest.transpose();
    for (int k = 0; k < 3; ++k) pin.motion.corners(p, k) = rider.corners[std::size_t(k)];
    pin.motion.shares.row(p) = rider.shares.transpose();
    pin.part[p] = rider.part;
  }
  pin.points = embed_points(pin.rest, lattice, "inside: point");
}

}  // namespace

double cell_of(const Lattice& lattice) {
  if (lattice.is_regular()) return lattice.cell_size.minCoeff();
  const Vector3d size =
      (lattice.rest_positions.colwise().maxCoeff() - lattice.rest_positions.colwise().minCoeff()).transpose();
  return std::cbrt(size.prod() / double(lattice.num_hexes()));
}

HeldByBones hold_bones(const MeshSource& inside, const PlacedMesh& shape, const Lattice& lattice, Pin& pin,
                       std::vector<std::string>& warnings) {
  MeshFile file = load_mesh(inside.path);
  for (auto position : file.mesh.positions.rowwise())
    position = (shape.world_from_file * Vector3d(position.transpose())).transpose();
  const Bones bones = bones_of(std::move(file.mesh));
  const Eigen::Index count = bones.mesh.num_vertices();
  HeldByBones held{{count, std::move(file.vertex_in_file), count + file.loose_vertices.rows(), bones.mesh.triangles},
                   {}};
  std::vector<Rider> riders = inside_of(lattice, riders_on(bones, cell_of(lattice)), inside, warnings, pin.name);
  for (InnerRider& found : riders_in(bones, lattice)) {
    found.rider.corners.fill(int(count) + int(held.inner.size()));
    riders.push_back(found.rider);
    held.inner.push_back(found.inner);
  }
  give_points(riders, lattice, pin);
  return held;
}

MeshMotion with_inner_points(MeshMotion motion, const std::vector<InnerPoint>& inner) {
  const auto before = std::size_t(motion.num_vertices), after = before + inner.size();
  std::vector<float> samples;
  samples.reserve(3 * after * motion.times.size());
  for (std::size_t i = 0; i < motion.times.size(); ++i) {
    const float* sample = motion.samples.data() + 3 * before * i;
    samples.insert(samples.end(), sample, sample + 3 * before);
    for (const InnerPoint& point : inner)
      for (int axis = 0; axis < 3; ++axis) {
        double place = 0;
        for (int k = 0; k < 4; ++k) place += point.shares[k] * double(sample[3 * point.corners[std::size_t(k)] + axis]);
        samples.push_back(float(place));
      }
  }
  motion.samples = std::move(samples);
  motion.num_vertices = Eigen::Index(after);
  return motion;
}

}  // namespace umax
