#include "embedding/surface/hex_faces.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace umax {

std::array<int, 4> HexFace::sorted_corners() const {
  std::array<int, 4> sorted = corners;
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

std::vector<HexFace> hex_faces(const Hexes& hexes) {
  std::vector<std::pair<std::array<int, 4>, HexFace>> keyed;
  keyed.reserve(6 * std::size_t(hexes.rows()));
  for (int e = 0; e < int(hexes.rows()); ++e)
    for (const auto& local : hex_face_corners) {
      HexFace face{.corners = {hexes(e, local[0]), hexes(e, local[1]), hexes(e, local[2]), hexes(e, local[3])},
                   .hex = e};
      std::rotate(face.corners.begin(), std::min_element(face.corners.begin(), face.corners.end()), face.corners.end());
      keyed.emplace_back(face.sorted_corners(), face);
    }
  std::sort(keyed.begin(), keyed.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.hex, a.second.corners) < std::tie(b.first, b.second.hex, b.second.corners);
  });
  std::vector<HexFace> faces;
  faces.reserve(keyed.size());
  for (const auto& [key, face] : keyed) faces.push_back(face);
  return faces;
}

std::vector<HexFace> boundary_faces(const Hexes& hexes) {
  std::vector<HexFace> boundary;
  for_each_face(hex_faces(hexes), [&](auto first, auto last) {
    if (last - first == 1) boundary.push_back(*first);
  });
  return boundary;
}

std::vector<std::pair<int, int>> outer_edges(const Hexes& hexes) {
  std::vector<std::pair<int, int>> edges;
  for (const HexFace& face : boundary_faces(hexes))
    for (std::size_t i = 0; i < 4; ++i) edges.push_back(std::minmax({face.corners[i], face.corners[(i + 1) % 4]}));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

HexSurface surface_of(const Points& nodes, const Hexes& hexes) {
  const std::vector<HexFace> faces = boundary_faces(hexes);
  std::vector<int> vertex(std::size_t(nodes.rows()), -1);
  for (const HexFace& face : faces)
    for (const int node : face.corners) vertex[std::size_t(node)] = 0;
  HexSurface surface;
  for (int node = 0; node < int(vertex.size()); ++node)
    if (vertex[std::size_t(node)] == 0) {
      vertex[std::size_t(node)] = int(surface.nodes.size());
      surface.nodes.push_back(node);
    }

  surface.mesh.positions.resize(Eigen::Index(surface.nodes.size()), 3);
  for (std::size_t v = 0; v < surface.nodes.size(); ++v)
    surface.mesh.positions.row(Eigen::Index(v)) = nodes.row(surface.nodes[v]);
  surface.mesh.triangles.resize(2 * Eigen::Index(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::array<int, 4> v{};
    for (std::size_t k = 0; k < 4; ++k) v[k] = vertex[std::size_t(faces[f].corners[k])];
    surface.mesh.triangles.row(2 * Eigen::Index(f)) << v[0], v[1], v[2];
    surface.mesh.triangles.row(2 * Eigen::Index(f) + 1) << v[0], v[2], v[3];
  }
  return surface;
}

}  // namespace umax
