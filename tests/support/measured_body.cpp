#include "tests/support/measured_body.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_set>

namespace umax::test {
namespace {

using Hexes3 = std::array<int, 3>;

EmbeddedPoints vertices_of(const Model& model, int body) {
  EmbeddedPoints points = *model.bodies[std::size_t(body)].surface;
  points.hex.array() += model.bodies[std::size_t(body)].first_hex;
  return points;
}

Triangles outward(Triangles triangles, const Points& positions) {
  double volume = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto corner = [&](int i) -> Vector3d { return positions.row(triangles(t, i)).transpose(); };
    volume += corner(0).dot(corner(1).cross(corner(2)));
  }
  if (volume < 0) triangles.col(1).swap(triangles.col(2));
  return triangles;
}

// vertices of triangle t that no triangle before it has, then the points that divide its edges into `parts`
void add_points(const Vector3i& corners, int parts, std::vector<char>& seen, std::vector<SurfacePoint>& points) {
  for (int i = 0; i < 3; ++i)
    if (!std::exchange(seen[corners[i]], char(1))) points.push_back({corners, Vector3d::Unit(i)});
  for (int i = 0; i <= parts; ++i)
    for (int j = 0; i + j <= parts; ++j) {
      const Vector3i share(i, j, parts - i - j);
      if (share.maxCoeff() < parts) points.push_back({corners, share.cast<double>() / parts});
    }
}

void add_edges(const Vector3i& corners, std::unordered_set<std::uint64_t>& seen,
               std::vector<std::array<int, 2>>& edges) {
  for (int i = 0; i < 3; ++i) {
    const auto [low, high] = std::minmax(corners[i], corners[(i + 1) % 3]);
    if (seen.insert(std::uint64_t(low) << 32 | std::uint64_t(high)).second) edges.push_back({low, high});
  }
}

double longest_edge(const Vector3i& corners, const Points& positions) {
  double longest = 0;
  for (int i = 0; i < 3; ++i)
    longest = std::max(longest, (positions.row(corners[i]) - positions.row(corners[(i + 1) % 3])).norm());
  return longest;
}

void add_points_and_edges(double spacing, MeasuredBody& out) {
  std::vector<char> seen_points(std::size_t(out.vertices.size()));
  std::unordered_set<std::uint64_t> seen_edges;
  seen_edges.reserve(2 * std::size_t(out.tree.triangles.rows()));
  for (Eigen::Index t = 0; t < out.tree.triangles.rows(); ++t) {
    out.point_starts.push_back(int(out.points.size()));
    out.edge_starts.push_back(int(out.edges.size()));
    const Vector3i corners = out.tree.triangles.row(t).transpose();
    const int parts = std::max(1, int(std::ceil(longest_edge(corners, out.rest.positions) / spacing)));
    add_points(corners, parts, seen_points, out.points);
    add_edges(corners, seen_edges, out.edges);
  }
  out.point_starts.push_back(int(out.points.size()));
  out.edge_starts.push_back(int(out.edges.size()));
}

// ascending, without repetitions but of the last one
Hexes3 ordered(Hexes3 hexes) {
  std::sort(hexes.begin(), hexes.end());
  std::fill(std::unique(hexes.begin(), hexes.end()), hexes.end(), hexes.back());
  return hexes;
}

Hexes3 hexes_of(const EmbeddedPoints& vertices, const SurfacePoint& point) {
  int first = 0;
  point.weights.maxCoeff(&first);
  Hexes3 hexes;
  for (int i = 0; i < 3; ++i) hexes[i] = vertices.hex[point.corners[point.weights[i] > 0 ? i : first]];
  return ordered(hexes);
}

std::vector<SamePlace> places_of(const MeasuredBody& body) {
  std::map<Hexes3, SamePlace> places;
  for (std::size_t p = 0; p < body.points.size(); ++p)
    places[hexes_of(body.vertices, body.points[p])].points.push_back(int(p));
  for (std::size_t e = 0; e < body.edges.size(); ++e) {
    const int a = body.vertices.hex[body.edges[e][0]], b = body.vertices.hex[body.edges[e][1]];
    places[ordered({a, b, b})].edges.push_back(int(e));
  }
  std::vector<SamePlace> list;
  for (auto& [hexes, place] : places) {
    place.hexes = hexes;
    list.push_back(std::move(place));
  }
  return list;
}

std::vector<std::vector<int>> triangles_by_hex(const Model& model, const MeasuredBody& body) {
  const Model::BodyRange& range = model.bodies[body.body];
  std::vector<std::vector<int>> by_hex(std::size_t(range.num_hexes));
  for (Eigen::Index t = 0; t < body.tree.triangles.rows(); ++t)
    for (int i = 0; i < 3; ++i) {
      std::vector<int>& list = by_hex[body.vertices.hex[body.tree.triangles(t, i)] - range.first_hex];
      if (list.empty() || list.back() != int(t)) list.push_back(int(t));
    }
  return by_hex;
}

}  // namespace

MeasuredBody measured_body(const Model& model, int body, const Triangles& triangles, const MeasureOptions& options) {
  MeasuredBody out;
  out.body = body;
  out.vertices = vertices_of(model, body);
  Points rest = vertex_positions(model, out, model.rest_positions);
  out.tree = build_tree(outward(triangles, rest), rest);
  out.rest = shape_tree(out.tree, std::move(rest));
  add_points_and_edges(options.spacing * model.bodies[body].cell_size, out);
  out.places = places_of(out);
  out.hex_triangles = triangles_by_hex(model, out);
  return out;
}

Points vertex_positions(const Model& model, const MeasuredBody& body, const Points& node_positions) {
  Points positions(body.vertices.size(), 3);
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    positions.row(v) = body.vertices.weights.row(v) * hex_nodes(model, node_positions, body.vertices.hex[v]);
  return positions;
}

Vector3d point_at(const SurfacePoint& point, const Points& positions) {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) sum += point.weights[i] * positions.row(point.corners[i]).transpose();
  return sum;
}

double longest_edge(const MeasuredBody& body, const Points& positions) {
  double longest = 0;
  for (Eigen::Index t = 0; t < body.tree.triangles.rows(); ++t)
    longest = std::max(longest, longest_edge(body.tree.triangles.row(t).transpose(), positions));
  return longest;
}

}  // namespace umax::test
