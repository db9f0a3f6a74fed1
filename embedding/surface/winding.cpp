#include "embedding/surface/winding.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "embedding/surface/topology.h"

namespace umax {
namespace {

// one side that the chain's boundary runs through `times` times
struct BoundaryEdge {
  int from = 0, to = 0, times = 0;
};

std::vector<BoundaryEdge> chain_boundary(const Triangles& triangles, const std::vector<int>& welded) {
  std::vector<BoundaryEdge> boundary;
  for_each_edge(edge_uses(triangles, welded), [&](auto first, auto last) {
    int net = 0;
    for (auto use = first; use != last; ++use) net += use->forward ? 1 : -1;
    if (net > 0) boundary.push_back({first->low, first->high, net});
    if (net < 0) boundary.push_back({first->high, first->low, -net});
  });
  return boundary;
}

// apex of every connected part of the boundary: the centroid of its edges
std::map<int, Vector3d> apexes_by_root(const std::vector<BoundaryEdge>& boundary, const Points& positions,
                                       DisjointSets& sets) {
  std::map<int, std::pair<Vector3d, double>> sums;
  for (const BoundaryEdge& edge : boundary) {
    const Vector3d a = positions.row(edge.from), b = positions.row(edge.to);
    auto& [sum, length] = sums.try_emplace(sets.root(edge.from), Vector3d::Zero(), 0.0).first->second;
    sum += 0.5 * (a + b) * (b - a).norm();
    length += (b - a).norm();
  }
  std::map<int, Vector3d> apexes;
  for (const auto& [root, sum] : sums) apexes[root] = sum.first / sum.second;
  return apexes;
}

void cap_holes(ClosedSurface& surface, const std::vector<int>& welded) {
  const std::vector<BoundaryEdge> boundary = chain_boundary(surface.triangles, welded);
  surface.num_boundary_edges = int(boundary.size());
  if (boundary.empty()) return;
  DisjointSets sets(welded.size());
  for (const BoundaryEdge& edge : boundary) sets.merge(edge.from, edge.to);

  const std::map<int, Vector3d> apexes = apexes_by_root(boundary, surface.positions, sets);
  surface.num_holes = int(apexes.size());
  std::map<int, int> apex_index;
  Eigen::Index next_vertex = surface.positions.rows();
  surface.positions.conservativeResize(next_vertex + surface.num_holes, 3);
  for (const auto& [root, apex] : apexes) {
    apex_index[root] = int(next_vertex);
    surface.positions.row(next_vertex++) = apex;
  }

  Eigen::Index num_caps = 0, next = surface.triangles.rows();
  for (const BoundaryEdge& edge : boundary) num_caps += edge.times;
  surface.triangles.conservativeResize(next + num_caps, 3);
  for (const BoundaryEdge& edge : boundary)
    for (int k = 0; k < edge.times; ++k)
      surface.triangles.row(next++) << apex_index[sets.root(edge.from)], edge.to, edge.from;
}

struct Crossing {
  int line = 0;  // (i within the group) * size.y + j
  double z = 0;
  int change = 0;  // of the winding number on the way up
};
bool operator<(const Crossing& a, const Crossing& b) {
  return std::tie(a.line, a.z, a.change) < std::tie(b.line, b.z, b.change);
}

// where an edge passes the plane x; the same bits from both of its triangles
Eigen::Vector2d cross_plane(Vector3d p, Vector3d q, double x) {
  if (std::tie(q[0], q[1], q[2]) < std::tie(p[0], p[1], p[2])) std::swap(p, q);
  const double t = (x - p[0]) / (q[0] - p[0]);
  return {p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])};
}

// crossings of one triangle with the lines of one plane x. Half-open rules in x and y: a line through an edge or a
// vertex meets exactly one of the triangles around it.
void cross_triangle(const std::array<Vector3d, 3>& corners, double x, double y_origin, double y_spacing, int size_y,
                    int first_line, std::vector<Crossing>& crossings) {
  Eigen::Vector2d rising, falling;  // (y, z) on the sides that run to larger and to smaller x
  int found = 0;
  for (int side = 0; side < 3; ++side) {
    const Vector3d &a = corners[std::size_t(side)], &b = corners[std::size_t((side + 1) % 3)];
    if ((a[0] <= x) == (b[0] <= x)) continue;
    (a[0] <= x ? rising : falling) = cross_plane(a, b, x);
    ++found;
  }
  if (found != 2 || rising[0] == falling[0]) return;
  const bool faces_up = rising[0] < falling[0];
  const Eigen::Vector2d &low = faces_up ? rising : falling, &high = faces_up ? falling : rising;

  const auto y_of = [&](int j) { return y_origin + j * y_spacing; };
  int j = int(std::clamp(std::ceil((low[0] - y_origin) / y_spacing) - 1, 0.0, double(size_y)));
  while (j < size_y && y_of(j) < low[0]) ++j;
  for (; j < size_y && y_of(j) < high[0]; ++j) {
    const double t = (y_of(j) - low[0]) / (high[0] - low[0]);
    crossings.push_back({first_line + j, low[1] + t * (high[1] - low[1]), faces_up ? -1 : 1});
  }
}

// first and one past the last line i whose plane the triangle may meet
std::pair<int, int> line_range(const std::array<Vector3d, 3>& corners, const LineGrid& lines) {
  const double low = std::min({corners[0][0], corners[1][0], corners[2][0]});
  const double high = std::max({corners[0][0], corners[1][0], corners[2][0]});
  const double size = lines.size[0];
  const int first = int(std::clamp(std::floor((low - lines.origin[0]) / lines.spacing[0]), 0.0, size));
  const int last = int(std::clamp(std::ceil((high - lines.origin[0]) / lines.spacing[0]) + 1, 0.0, size));
  return {first, last};
}

}  // namespace

ClosedSurface close_surface(const TriangleMesh& mesh) {
  ClosedSurface surface;
  const std::vector<int> welded = weld(mesh.positions);
  surface.positions = mesh.positions;
  surface.triangles = oriented_consistently(mesh, welded, &surface.num_turned);
  cap_holes(surface, welded);
  surface.volume = signed_volume(surface.positions, surface.triangles);
  return surface;
}

void visit_inside(const ClosedSurface& surface, const LineGrid& lines,
                  const std::function<void(int, int, double, double)>& visit) {
  const int num_groups = (lines.size[0] + lines.group - 1) / lines.group;
  const auto corners_of = [&](int t) {
    std::array<Vector3d, 3> corners;
    for (int k = 0; k < 3; ++k) corners[std::size_t(k)] = surface.positions.row(surface.triangles(t, k));
    return corners;
  };

  // triangles that each group must look at
  std::vector<std::vector<int>> triangles_of_group(static_cast<std::size_t>(num_groups));
  for (int t = 0; t < int(surface.triangles.rows()); ++t) {
    const auto [first, last] = line_range(corners_of(t), lines);
    for (int g = first / lines.group; first < last && g <= (last - 1) / lines.group; ++g)
      triangles_of_group[std::size_t(g)].push_back(t);
  }

  tbb::parallel_for(0, num_groups, [&](int g) {
    const int first_i = g * lines.group, last_i = std::min(lines.size[0], first_i + lines.group);
    std::vector<Crossing> crossings;
    for (int t : triangles_of_group[std::size_t(g)]) {
      const auto corners = corners_of(t);
      const auto [first, last] = line_range(corners, lines);
      for (int i = std::max(first, first_i); i < std::min(last, last_i); ++i)
        cross_triangle(corners, lines.origin[0] + i * lines.spacing[0], lines.origin[1], lines.spacing[1],
                       lines.size[1], (i - first_i) * lines.size[1], crossings);
    }
    std::sort(crossings.begin(), crossings.end());

    // walk up every line
    for (std::size_t c = 0; c < crossings.size();) {
      const int line = crossings[c].line;
      int winding = 0;
      double entered = 0;
      for (; c < crossings.size() && crossings[c].line == line; ++c) {
        const int before = winding;
        winding += crossings[c].change;
        if (before == 0 && winding != 0) entered = crossings[c].z;
        if (before != 0 && winding == 0 && crossings[c].z > entered)
          visit(first_i + line / lines.size[1], line % lines.size[1], entered, crossings[c].z);
      }
    }
  });
}

double num_crossings(const ClosedSurface& surface, const LineGrid& lines) {
  double area = 0;
  for (int t = 0; t < int(surface.triangles.rows()); ++t) {
    const Vector3d a = surface.positions.row(surface.triangles(t, 0)),
                   b = surface.positions.row(surface.triangles(t, 1)),
                   c = surface.positions.row(surface.triangles(t, 2));
    area += 0.5 * std::abs((b - a).cross(c - a)[2]);
  }
  return area / lines.spacing.prod();
}

double inside_volume(const ClosedSurface& surface, int num_lines) {
  const Vector3d low = surface.positions.colwise().minCoeff(), high = surface.positions.colwise().maxCoeff();
  LineGrid lines;
  lines.spacing = (high - low).head<2>() / num_lines;
  if (!(lines.spacing.minCoeff() > 0)) return 0;
  for (; num_lines > 1 && num_crossings(surface, lines) > most_crossings; num_lines /= 2) lines.spacing *= 2;
  lines.size = {num_lines, num_lines};
  lines.origin = low.head<2>() + 0.5 * lines.spacing;
  std::vector<double> length(std::size_t(num_lines), 0.0);  // per plane: summed in a fixed order
  visit_inside(surface, lines, [&](int i, int, double z0, double z1) { length[std::size_t(i)] += z1 - z0; });
  double sum = 0;
  for (double l : length) sum += l;
  return sum * lines.spacing[0] * lines.spacing[1];
}

}  // namespace umax
