#include "embedding/surface/shapes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace umax {
namespace {

void require_positive(const char* key, double value) {
  if (value > 0 && std::isfinite(value)) return;
  throw Error(Fault::bad_data,
              {key, "must be a positive length", fmt::format("{:g} m", value), "give a length such as \"1 m\""});
}

struct MeshBuilder {
  std::vector<Vector3d> positions, normals;
  std::vector<Vector3i> triangles;

  int add(const Vector3d& position, const Vector3d& normal) {
    positions.push_back(position);
    normals.push_back(normal);
    return int(positions.size()) - 1;
  }
  // corners counter-clockwise from outside
  void add_quad(int a, int b, int c, int d) {
    triangles.emplace_back(a, b, c);
    triangles.emplace_back(a, c, d);
  }
  TriangleMesh mesh() const {
    TriangleMesh result;
    result.positions.resize(Eigen::Index(positions.size()), 3);
    result.normals.resize(Eigen::Index(positions.size()), 3);
    result.triangles.resize(Eigen::Index(triangles.size()), 3);
    for (std::size_t v = 0; v < positions.size(); ++v) {
      result.positions.row(Eigen::Index(v)) = positions[v];
      result.normals.row(Eigen::Index(v)) = normals[v];
    }
    for (std::size_t t = 0; t < triangles.size(); ++t) result.triangles.row(Eigen::Index(t)) = triangles[t];
    return result;
  }
};

// grid of quads on the side of the box that faces `sign` along `axis`
void add_box_side(const Vector3d& size, const Vector3i& divisions, int axis, int sign, MeshBuilder& builder) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<int> row_below;
  for (int j = 0; j <= divisions[v]; ++j) {
    std::vector<int> row;
    for (int i = 0; i <= divisions[u]; ++i) {
      Vector3d p;
      p[axis] = 0.5 * sign * size[axis];
      p[u] = (double(i) / divisions[u] - 0.5) * size[u];
      p[v] = (double(j) / divisions[v] - 0.5) * size[v];
      row.push_back(builder.add(p, sign * Vector3d::Unit(axis)));
    }
    for (int i = 0; j > 0 && i < divisions[u]; ++i) {
      if (sign > 0)
        builder.add_quad(row_below[i], row_below[i + 1], row[i + 1], row[i]);
      else
        builder.add_quad(row_below[i], row[i], row[i + 1], row_below[i + 1]);
    }
    row_below = std::move(row);
  }
}

using Edge = std::pair<int, int>;

// splits every triangle in four; new vertices are pushed out to the unit sphere
void refine_sphere(std::vector<Vector3d>& positions, std::vector<Vector3i>& triangles) {
  std::map<Edge, int> midpoints;
  const auto midpoint = [&](int a, int b) {
    const auto [entry, is_new] = midpoints.try_emplace({std::min(a, b), std::max(a, b)}, int(positions.size()));
    if (is_new) positions.push_back((positions[a] + positions[b]).normalized());
    return entry->second;
  };
  std::vector<Vector3i> refined;
  refined.reserve(4 * triangles.size());
  for (const Vector3i& t : triangles) {
    const int ab = midpoint(t[0], t[1]), bc = midpoint(t[1], t[2]), ca = midpoint(t[2], t[0]);
    refined.insert(refined.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
  }
  triangles = std::move(refined);
}

// rings from the rim to the centre of the end that faces `sign` along x
void add_cap(double radius, double x, int sign, int segments, MeshBuilder& builder) {
  const Vector3d normal = sign * Vector3d::UnitX();
  const int num_rings = std::max(2, segments / 6);
  std::vector<int> outer;
  for (int ring = 0; ring < num_rings; ++ring) {
    std::vector<int> inner;
    const double r = radius * (num_rings - ring) / num_rings;
    for (int i = 0; i < segments; ++i) {
      const double angle = 2 * std::numbers::pi * i / segments;
      inner.push_back(builder.add({x, r * std::cos(angle), r * std::sin(angle)}, normal));
    }
    for (int i = 0; ring > 0 && i < segments; ++i) {
      const int j = (i + 1) % segments;
      if (sign > 0)
        builder.add_quad(outer[i], outer[j], inner[j], inner[i]);
      else
        builder.add_quad(outer[i], inner[i], inner[j], outer[j]);
    }
    outer = std::move(inner);
  }
  const int centre = builder.add({x, 0, 0}, normal);
  for (int i = 0; i < segments; ++i) {
    const int j = (i + 1) % segments;
    if (sign > 0)
      builder.triangles.emplace_back(centre, outer[i], outer[j]);
    else
      builder.triangles.emplace_back(centre, outer[j], outer[i]);
  }
}

}  // namespace

TriangleMesh make_box(const Vector3d& size) {
  for (double edge : size) require_positive("size", edge);
  const double spacing = size.maxCoeff() / 48;
  Vector3i divisions;
  for (int axis = 0; axis < 3; ++axis) divisions[axis] = std::max(1, int(std::lround(size[axis] / spacing)));
  MeshBuilder builder;
  for (int axis = 0; axis < 3; ++axis)
    for (int sign : {-1, 1}) add_box_side(size, divisions, axis, sign, builder);
  return builder.mesh();
}

TriangleMesh make_sphere(double radius, int subdivisions) {
  require_positive("radius", radius);
  if (subdivisions < 0 || subdivisions > 11)
    throw Error(Fault::bad_data, {"sphere", "subdivisions must be 0 to 11", std::to_string(subdivisions), ""});

  // the icosahedron, stood on a vertex's edge
  const double g = std::numbers::phi;
  std::vector<Vector3d> positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                     {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<Vector3i> triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (Vector3d& p : positions) p.normalize();
  for (int i = 0; i < subdivisions; ++i) refine_sphere(positions, triangles);

  MeshBuilder builder;
  for (const Vector3d& p : positions) builder.add(radius * p, p);
  builder.triangles = std::move(triangles);
  return builder.mesh();
}

TriangleMesh make_cylinder(double radius, double length) {
  require_positive("radius", radius);
  require_positive("length", length);
  constexpr int segments = 64;
  const double spacing = 2 * std::numbers::pi * radius / segments;
  const int num_rings = int(std::clamp(std::ceil(length / spacing), 4.0, 2000.0));
  MeshBuilder builder;
  for (int ring = 0; ring <= num_rings; ++ring)
    for (int i = 0; i < segments; ++i) {
      const double angle = 2 * std::numbers::pi * i / segments, c = std::cos(angle), s = std::sin(angle);
      builder.add({(double(ring) / num_rings - 0.5) * length, radius * c, radius * s}, {0, c, s});
    }
  for (int ring = 0; ring < num_rings; ++ring)
    for (int i = 0; i < segments; ++i) {
      const int j = (i + 1) % segments, a = ring * segments, b = a + segments;
      builder.add_quad(a + i, a + j, b + j, b + i);
    }
  add_cap(radius, -0.5 * length, -1, segments, builder);
  add_cap(radius, 0.5 * length, 1, segments, builder);
  return builder.mesh();
}

TriangleMesh make_ring(double radius, double thickness) {
  require_positive("radius", radius);
  require_positive("thickness", thickness);
  if (!(thickness < 2 * radius))
    throw Error(Fault::bad_data, {"ring", "leaves no hole", fmt::format("a thickness of {:g} m", thickness),
                                  fmt::format("give one below twice its radius, {:g} m", 2 * radius)});
  constexpr int segments = 192, around = 64;
  MeshBuilder builder;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2 * std::numbers::pi * i / segments;
    const Vector3d outward(std::cos(angle), std::sin(angle), 0);
    for (int j = 0; j < around; ++j) {
      const double turn = 2 * std::numbers::pi * j / around;
      const Vector3d normal = std::cos(turn) * outward + std::sin(turn) * Vector3d::UnitZ();
      builder.add(radius * outward + 0.5 * thickness * normal, normal);
    }
  }
  for (int i = 0; i < segments; ++i)
    for (int j = 0; j < around; ++j) {
      const int a = i * around, b = (i + 1) % segments * around, k = (j + 1) % around;
      builder.add_quad(a + j, b + j, b + k, a + k);
    }
  return builder.mesh();
}

TriangleMesh make_bowl(double radius, double thickness) {
  require_positive("radius", radius);
  require_positive("thickness", thickness);
  const double rim_angle = 65 * std::numbers::pi / 180, middle = radius / std::sin(rim_angle), half = thickness / 2;
  if (!(half < middle / 2))
    throw Error(Fault::bad_data, {"bowl", "thickness must be less than the radius", std::to_string(thickness), ""});
  constexpr int segments = 96, num_rings = 32, num_rim = 8;
  struct ProfilePoint {
    double x, y, nx, ny;  // y from the sphere's centre
  };
  std::vector<ProfilePoint> profile;  // outside from the bottom up, around the rim, inside down
  const auto add_sphere = [&](double angle, double r, double sign) {
    profile.push_back({r * std::sin(angle), -r * std::cos(angle), sign * std::sin(angle), -sign * std::cos(angle)});
  };
  for (int i = 0; i <= num_rings; ++i) add_sphere(rim_angle * i / num_rings, middle + half, 1);
  for (int i = 1; i < num_rim; ++i) {
    const double turn = rim_angle + std::numbers::pi * i / num_rim;  // of the normal, from straight down
    const double nx = std::sin(turn), ny = -std::cos(turn);
    profile.push_back({middle * std::sin(rim_angle) + half * nx, -middle * std::cos(rim_angle) + half * ny, nx, ny});
  }
  for (int i = num_rings; i >= 0; --i) add_sphere(rim_angle * i / num_rings, middle - half, -1);

  MeshBuilder builder;
  const auto place = [&](const ProfilePoint& p, double c, double s) {
    return builder.add({p.x * c, p.y + middle + half, p.x * s}, {p.nx * c, p.ny, p.nx * s});
  };
  const int bottom = place(profile.front(), 1, 0), inner_bottom = place(profile.back(), 1, 0);
  const int first = inner_bottom + 1, count = int(profile.size()) - 2;  // rings between
  for (int ring = 0; ring < count; ++ring)
    for (int i = 0; i < segments; ++i) {
      const double angle = 2 * std::numbers::pi * i / segments;
      place(profile[std::size_t(ring) + 1], std::cos(angle), std::sin(angle));
    }
  for (int i = 0; i < segments; ++i) {
    const int j = (i + 1) % segments, last = first + (count - 1) * segments;
    builder.triangles.emplace_back(bottom, first + i, first + j);
    builder.triangles.emplace_back(inner_bottom, last + j, last + i);
    for (int a = first; a < last; a += segments) builder.add_quad(a + i, a + segments + i, a + segments + j, a + j);
  }
  return builder.mesh();
}

TriangleMesh make_plane(double size) {
  require_positive("size", size);
  const double h = 0.5 * size;
  MeshBuilder builder;
  const Vector3d up = Vector3d::UnitY();
  const int a = builder.add({-h, 0, h}, up), b = builder.add({h, 0, h}, up), c = builder.add({h, 0, -h}, up),
            d = builder.add({-h, 0, -h}, up);
  builder.add_quad(a, b, c, d);
  return builder.mesh();
}

}  // namespace umax
