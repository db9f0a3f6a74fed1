#include "embedding/hex_cage.h"

#include <Eigen/LU>
#include <cmath>

#include "core/hexahedron.h"
#include "core/parallel.h"
#include "embedding/distance_grid.h"
#include "embedding/winding.h"

namespace umax {
namespace {

double determinant_at(const Matrix8x3d& nodes, const Vector3d& s) {
  return Matrix3d(nodes.transpose() * shape_gradients(s)).determinant();
}

// midpoint rule in the hex's own coordinates
double filled_share(const Matrix8x3d& nodes, const SampledDistance& distance, int samples) {
  double inside = 0, all = 0;
  const auto coordinate = [&](int i) { return (2 * i + 1.0) / samples - 1; };
  for (int i = 0; i < samples; ++i)
    for (int j = 0; j < samples; ++j)
      for (int k = 0; k < samples; ++k) {
        const Vector3d s(coordinate(i), coordinate(j), coordinate(k));
        const double weight = determinant_at(nodes, s);
        all += weight;
        if (signed_distance(distance, nodes.transpose() * shape_functions(s)).distance < 0) inside += weight;
      }
  return inside / all;
}

}  // namespace

VectorXd hex_volumes(const Lattice& lattice) {
  VectorXd volumes = VectorXd::Zero(lattice.num_hexes());
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e)
    for (const Vector3d& s : quadrature_points()) volumes[e] += determinant_at(rest_nodes(lattice, e), s);
  return volumes;
}

Lattice make_hex_cage(const TriangleMesh& surface, const Points& nodes, const Hexes& hexes,
                      const HexCageOptions& options, CageReport* report) {
  Lattice lattice = make_irregular_lattice(nodes, hexes);
  validate(lattice);
  CageReport found;
  if (options.is_the_body) {
    found.method = "the file's hexes";
  } else {
    const SampledDistance distance = make_distance_grid(surface, {}, &found.notes);
    parallel_blocks(lattice.num_hexes(), 64, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index e = begin; e < end; ++e)
        lattice.filled_fraction[e] = filled_share(rest_nodes(lattice, e), distance, options.samples);
    });
    found.method = "sampled distances";
  }
  if (!report) return lattice;
  found.mesh_volume = std::abs(close_surface(surface).volume);
  found.filled_volume = lattice.filled_fraction.dot(hex_volumes(lattice));
  report_connections(lattice, found);
  *report = found;
  return lattice;
}

}  // namespace umax
