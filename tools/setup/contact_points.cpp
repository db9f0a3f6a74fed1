#include "tools/setup/contact_points.h"

#include <vector>

#include "embedding/surface/surface_samples.h"

namespace umax {
namespace {

constexpr double largest_spacing = 0.25;  // [cells]
constexpr double ridge_depth = 0.01;      // [cells]

// [m] edges of a regular cage's cells, of other hexes the mean length
Vector3d cell_edges(const Lattice& lattice) {
  if (lattice.is_regular()) return lattice.cell_size;
  double sum = 0;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    for (int n = 0; n < 8; ++n)
      for (int bit = 1; bit < 8; bit <<= 1)
        if (!(n & bit))
          sum +=
              (lattice.rest_positions.row(lattice.hexes(e, n)) - lattice.rest_positions.row(lattice.hexes(e, n | bit)))
                  .norm();
  return Vector3d::Constant(sum / (12 * double(lattice.num_hexes())));
}

// those that lie in the lattice
EmbeddedPoints embed_inside(const Points& points, const Lattice& lattice) {
  const VectorXi hexes = find_hexes(points, lattice);
  std::vector<Eigen::Index> inside;
  for (Eigen::Index p = 0; p < points.rows(); ++p)
    if (hexes[p] >= 0) inside.push_back(p);
  return embed_points(points(inside, Eigen::all), lattice);
}

}  // namespace

EmbeddedPoints points_between_vertices(const BodySetup& setup, const Body& body) {
  const TriangleMesh& mesh = setup.shape.mesh;
  const Vector3d edges = cell_edges(setup.lattice);
  SurfaceSampling sampling{.spacing = largest_spacing,
                           .ridge_depth = ridge_depth * edges.minCoeff(),
                           .num_given = mesh.num_vertices(),
                           .to_cells = edges.cwiseInverse().asDiagonal()};
  if (!body.rest_surface)
    return embed_inside(sample_between_vertices(make_rest_surface(mesh.positions, mesh.triangles), sampling),
                        setup.lattice);
  sampling.to_cells = body.rest_scale * sampling.to_cells * body.rest_pose.rotation;
  sampling.ridge_depth /= body.rest_scale;
  Points points = sample_between_vertices(*body.rest_surface, sampling);
  for (auto point : points.rowwise()) point = body.rest_pose.world(body.rest_scale * point.transpose()).transpose();
  return embed_inside(points, setup.lattice);
}

void append(const EmbeddedPoints& points, EmbeddedPoints& all) {
  const Eigen::Index known = all.size();
  all.hex.conservativeResize(known + points.size());
  all.hex.tail(points.size()) = points.hex;
  all.weights.conservativeResize(known + points.size(), 8);
  all.weights.bottomRows(points.size()) = points.weights;
}

}  // namespace umax
