#include "embedding/cage/hex_cage.h"

#include <Eigen/LU>
#include <cmath>

#include "core/base/parallel.h"
#include "core/element/hexahedron.h"
#include "embedding/surface/distance_grid.h"
#include "embedding/surface/winding.h"

namespace umax {
namespace {

double determinant_at(const Matrix8x3d& nodes, const Vector3d& s) {
  return Matrix3d(nodes.transpose() * shape_gradients(s)).determinant();
}

double filled_share(const Matrix8x3d& nodes, const SampledDistance& distance, int per_axis) {
  const HexSamples samples = sample_hex(nodes, per_axis);
  double inside = 0, all = 0;
  for (Eigen::Index p = 0; p < samples.weights.size(); ++p) {
    all += samples.weights[p];
    if (signed_distance(distance, samples.points.row(p)).distance < 0) inside += samples.weights[p];
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

HexSamples sample_hex(const Matrix8x3d& nodes, int per_axis) {
  const Eigen::Index count = Eigen::Index(per_axis) * per_axis * per_axis;
  HexSamples samples{Points(count, 3), VectorXd(count)};
  const auto coordinate = [&](int i) { return (2 * i + 1.0) / per_axis - 1; };
  Eigen::Index p = 0;
  for (int i = 0; i < per_axis; ++i)
    for (int j = 0; j < per_axis; ++j)
      for (int k = 0; k < per_axis; ++k, ++p) {
        const Vector3d s(coordinate(i), coordinate(j), coordinate(k));
        samples.points.row(p) = (nodes.transpose() * shape_functions(s)).transpose();
        samples.weights[p] = determinant_at(nodes, s);
      }
  return samples;
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
