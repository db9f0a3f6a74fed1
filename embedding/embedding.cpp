#include "embedding/embedding.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "core/error.h"
#include "embedding/cell_table.h"

namespace umax {
namespace {

constexpr Eigen::Index block_size = 4096;

template <class Body>
void parallel_blocks(Eigen::Index size, Body body) {
  tbb::parallel_for(tbb::blocked_range<Eigen::Index>(0, size, block_size),
                    [&](const tbb::blocked_range<Eigen::Index>& range) { body(range.begin(), range.end()); });
}

// hex of every point, and its coordinates there; hex -1: outside
void locate(const Points& points, const Lattice& lattice, VectorXi& hex, Points& local) {
  const CellTable table(lattice.cells);
  hex.resize(points.rows());
  local.resize(points.rows(), 3);
  parallel_blocks(points.rows(), [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index p = first; p < last; ++p) {
      const Vector3d s = (points.row(p).transpose() - lattice.origin).cwiseQuotient(lattice.cell_size);
      hex[p] = table.find(s);
      if (hex[p] >= 0) local.row(p) = s.transpose() - lattice.cells.row(hex[p]).cast<double>();
    }
  });
}

void require_inside(const Points& points, const Lattice& lattice, const VectorXi& hex, const char* what) {
  const auto outside = std::find(hex.begin(), hex.end(), -1);
  if (outside == hex.end()) return;
  const Eigen::Index p = outside - hex.begin();
  const Vector3d low = lattice.rest_positions.colwise().minCoeff(), high = lattice.rest_positions.colwise().maxCoeff();
  throw Error(ExitCode::bad_data,
              {fmt::format("{} {}", what, p), "lies outside the cage",
               fmt::format("({:g}, {:g}, {:g})", points(p, 0), points(p, 1), points(p, 2)),
               fmt::format("the cage spans ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}); give a point in one of its cells",
                           low[0], low[1], low[2], high[0], high[1], high[2])});
}

void trilinear_weights(const double* s, double* weights) {
  const std::array<double, 2> x{1 - s[0], s[0]}, y{1 - s[1], s[1]}, z{1 - s[2], s[2]};
  for (int n = 0; n < 8; ++n) weights[n] = x[n >> 2] * y[n >> 1 & 1] * z[n & 1];
}

EmbeddedPoints weighted(const VectorXi& hex, const Points& local) {
  EmbeddedPoints points;
  points.hex = hex;
  points.weights.resize(hex.size(), 8);
  parallel_blocks(hex.size(), [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index p = first; p < last; ++p) trilinear_weights(local.data() + 3 * p, points.weights.data() + 8 * p);
  });
  return points;
}

void require_regular(const Lattice& lattice) {
  if (lattice.cells.rows() == lattice.num_hexes() && (lattice.cell_size.array() > 0).all()) return;
  throw Error(ExitCode::bad_data,
              {"cage", "must be a regular lattice to hold a surface", "", "make it with voxelize()"});
}

// x(s) = c0 + c1 s1 + c2 s2 + c3 s3 + c4 s1 s2 + c5 s2 s3 + c6 s1 s3 + c7 s1 s2 s3
using Polynomial = std::array<double, 24>;

Polynomial trilinear_polynomial(const Hexes& hexes, int hex, const Points& nodes) {
  Polynomial c;
  for (int axis = 0; axis < 3; ++axis) {
    double x[8];
    for (int n = 0; n < 8; ++n) x[n] = nodes(hexes(hex, n), axis);
    const double x_edge = x[4] - x[0], y_edge = x[2] - x[0], z_edge = x[1] - x[0];
    c[axis] = x[0];
    c[3 + axis] = x_edge;
    c[6 + axis] = y_edge;
    c[9 + axis] = z_edge;
    c[12 + axis] = (x[6] - x[2]) - x_edge;
    c[15 + axis] = (x[3] - x[1]) - y_edge;
    c[18 + axis] = (x[5] - x[1]) - x_edge;
    c[21 + axis] = ((x[7] - x[3]) - (x[6] - x[2])) - ((x[5] - x[1]) - x_edge);
  }
  return c;
}

void deform_positions(const Embedding& embedding, const std::vector<Polynomial>& polynomials, Eigen::Index first,
                      Eigen::Index last, double* positions) {
  for (Eigen::Index v = first; v < last; ++v) {
    const double* s = embedding.local.data() + 3 * v;
    const double* c = polynomials[embedding.slot[v]].data();
    const double s12 = s[0] * s[1], s23 = s[1] * s[2], s13 = s[0] * s[2], s123 = s12 * s[2];
    for (int axis = 0; axis < 3; ++axis)
      positions[3 * v + axis] = c[axis] + c[3 + axis] * s[0] + c[6 + axis] * s[1] + c[9 + axis] * s[2] +
                                c[12 + axis] * s12 + c[15 + axis] * s23 + c[18 + axis] * s13 + c[21 + axis] * s123;
  }
}

}  // namespace

EmbeddedPoints embed_points(const Points& points, const Lattice& lattice, const char* what) {
  require_regular(lattice);
  VectorXi hex;
  Points local;
  locate(points, lattice, hex, local);
  require_inside(points, lattice, hex, what);
  return weighted(hex, local);
}

Embedding embed(const TriangleMesh& rest, const Lattice& lattice) {
  require_regular(lattice);
  Embedding embedding;
  VectorXi hex;
  locate(rest.positions, lattice, hex, embedding.local);
  require_inside(rest.positions, lattice, hex, "vertex");
  embedding.points = weighted(hex, embedding.local);

  // number the hexes that hold a vertex
  std::vector<int> slot_of_hex(std::size_t(lattice.num_hexes()), -1);
  for (int e : hex) slot_of_hex[e] = 0;
  for (int e = 0; e < int(lattice.num_hexes()); ++e)
    if (slot_of_hex[e] == 0) {
      slot_of_hex[e] = int(embedding.used_hexes.size());
      embedding.used_hexes.push_back(e);
    }
  embedding.slot.resize(std::size_t(hex.size()));
  for (Eigen::Index v = 0; v < hex.size(); ++v) embedding.slot[v] = slot_of_hex[hex[v]];

  embedding.fans = make_vertex_fans(rest);
  return embedding;
}

void deform(const Embedding& embedding, const Hexes& hexes, const Points& nodes, TriangleMesh& out) {
  const Eigen::Index num_vertices = embedding.local.rows();
  if (out.positions.rows() != num_vertices) out.positions.resize(num_vertices, 3);
  if (out.normals.rows() != num_vertices) out.normals.resize(num_vertices, 3);

  std::vector<Polynomial> polynomials(embedding.used_hexes.size());
  parallel_blocks(Eigen::Index(polynomials.size()), [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index i = first; i < last; ++i)
      polynomials[i] = trilinear_polynomial(hexes, embedding.used_hexes[i], nodes);
  });
  parallel_blocks(num_vertices, [&](Eigen::Index first, Eigen::Index last) {
    deform_positions(embedding, polynomials, first, last, out.positions.data());
  });
  parallel_blocks(num_vertices, [&](Eigen::Index first, Eigen::Index last) {
    compute_normals(embedding.fans, out.positions, first, last, out.normals);
  });
}

Points deform_points(const EmbeddedPoints& points, const Hexes& hexes, const Points& nodes) {
  Points positions(points.size(), 3);
  for (Eigen::Index p = 0; p < points.size(); ++p) {
    Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
    for (int n = 0; n < 8; ++n) x += points.weights(p, n) * nodes.row(hexes(points.hex[p], n));
    positions.row(p) = x;
  }
  return positions;
}

}  // namespace umax
