// What detection keeps during a run: made for a whole model, or taken over for some of its bodies.
#include <algorithm>
#include <iterator>
#include <limits>

#include "core/contact/contact.h"
#include "core/contact/edge_contact.h"

namespace umax {
namespace {

// the rows of one body in lists of the whole model and of a part of it
struct Places {
  const Model::BodyRange &there, &here;
  int points_there = 0, points_here = 0;  // where its vertices begin among those ordered by hex
};

// appends a body's list of vertices by hex
void append_points(const std::vector<int>& from, const Places& of, std::vector<int>& to) {
  const auto first = from.begin() + of.points_there;
  std::transform(first, first + of.there.num_points, std::back_inserter(to),
                 [&](int point) { return point + of.here.first_point - of.there.first_point; });
}

void append_clusters(const VertexClusters& from, const Places& of, VertexClusters& to) {
  const int first = from.hex_starts[of.there.first_hex], known = int(to.all.size());
  for (int e = 1; e <= of.there.num_hexes; ++e)
    to.hex_starts.push_back(from.hex_starts[of.there.first_hex + e] - first + known);
  for (int c = first; c < from.hex_starts[of.there.first_hex + of.there.num_hexes]; ++c) {
    to.all.push_back(from.all[c]);
    to.all.back().first += of.points_here - of.points_there;
  }
  append_points(from.points, of, to.points);
}

HexTree moved(HexTree tree, int by) {
  for (HexTree::Node& node : tree.nodes)
    if (node.hex >= 0) node.hex += by;
  return tree;
}

// the touchable bodies among some, by their places there
std::vector<int> among(const std::vector<int>& surfaces, const std::vector<int>& bodies) {
  std::vector<int> found;
  for (const int body : surfaces) {
    const auto place = std::lower_bound(bodies.begin(), bodies.end(), body);
    if (place != bodies.end() && *place == body) found.push_back(int(place - bodies.begin()));
  }
  return found;
}

}  // namespace

ContactGeometry make_contact_geometry(const Model& model) {
  ContactGeometry geometry;
  geometry.hex_starts.assign(model.num_hexes() + 1, 0);
  for (const Model::BodyRange& body : model.bodies)
    for (const int hex : body.surface->hex) ++geometry.hex_starts[body.first_hex + hex + 1];
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) geometry.hex_starts[e + 1] += geometry.hex_starts[e];
  geometry.hex_points.resize(std::size_t(model.num_points()));
  std::vector<int> next(geometry.hex_starts.begin(), geometry.hex_starts.end() - 1);
  for (const Model::BodyRange& body : model.bodies)
    for (int p = 0; p < body.num_points; ++p)
      geometry.hex_points[next[body.first_hex + body.surface->hex[p]]++] = body.first_point + p;

  double cell_size = std::numeric_limits<double>::infinity();
  for (const Model::BodyRange& body : model.bodies) cell_size = std::min(cell_size, body.cell_size);
  for (const Obstacle& obstacle : model.obstacles) {
    geometry.edges.push_back(edge_points(obstacle.shape, cell_size / 6));
  }
  geometry.touchable = find_touchable(model);
  geometry.clusters = cluster_vertices(model, geometry.hex_starts, geometry.hex_points);
  return geometry;
}

ContactGeometry part_of(const Model& model, const ContactGeometry& geometry, const Model& part,
                        const std::vector<int>& bodies) {
  ContactGeometry of_part;
  of_part.edges = geometry.edges;  // sampled for the smallest cells of all
  of_part.hex_starts.assign(1, 0);
  of_part.clusters.hex_starts.assign(1, 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Model::BodyRange& there = model.bodies[bodies[i]];
    const Places places{there, part.bodies[i], geometry.hex_starts[there.first_hex], of_part.hex_starts.back()};
    for (int e = 1; e <= there.num_hexes; ++e)
      of_part.hex_starts.push_back(geometry.hex_starts[there.first_hex + e] - places.points_there + places.points_here);
    append_points(geometry.hex_points, places, of_part.hex_points);
    append_clusters(geometry.clusters, places, of_part.clusters);
    of_part.touchable.surfaces.push_back(among(geometry.touchable.surfaces[bodies[i]], bodies));
    of_part.touchable.trees.push_back(
        moved(geometry.touchable.trees[bodies[i]], part.bodies[i].first_hex - there.first_hex));
  }
  for (std::size_t i = 0; i < bodies.size(); ++i)  // what nothing of the part may touch needs none
    if (std::none_of(of_part.touchable.surfaces.begin(), of_part.touchable.surfaces.end(), [&](const auto& surfaces) {
          return std::binary_search(surfaces.begin(), surfaces.end(), int(i));
        }))
      of_part.touchable.trees[i] = {};
  return of_part;
}

}  // namespace umax
