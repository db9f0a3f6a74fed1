#include "embedding/embedding.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "embedding/cage/cell_table.h"
#include "embedding/cage/hex_search.h"
#include "embedding/surface/hex_faces.h"

namespace umax {
namespace {

constexpr Eigen::Index block_size = 4096;

// hex of every point, and its coordinates there; hex -1: outside
void locate(const Points& points, const Lattice& lattice, VectorXi& hex, Points& local) {
  hex.resize(points.rows());
  local.resize(points.rows(), 3);
  if (!lattice.is_regular()) {
    const HexSearch search(lattice);
    parallel_blocks(points.rows(), block_size, [&](Eigen::Index first, Eigen::Index last) {
      for (Eigen::Index p = first; p < last; ++p) {
        Vector3d s(0, 0, 0);
        hex[p] = search.find(points.row(p), s);
        local.row(p) = s.transpose();
      }
    });
    return;
  }
  const CellTable table(lattice.cells);
  parallel_blocks(points.rows(), block_size, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index p = first; p < last; ++p) {
      const Vector3d s = (points.row(p).transpose() - lattice.origin).cwiseQuotient(lattice.cell_size);
      hex[p] = table.find(s);
      if (hex[p] >= 0) local.row(p) = s.transpose() - lattice.cells.row(hex[p]).cast<double>();
    }
  });
}

// how far a point is from a triangle's plane region, edges and corners [m]
double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  double nearest = std::numeric_limits<double>::infinity();
  bool above = normal.squaredNorm() > 0;
  for (const auto& [start, end] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
    const Vector3d edge = end - start;
    const double t = std::clamp((p - start).dot(edge) / std::max(edge.squaredNorm(), 1e-300), 0.0, 1.0);
    nearest = std::min(nearest, (start + t * edge - p).norm());
    above &= normal.dot(edge.cross(p - start)) >= 0;
  }
  return above ? std::min(nearest, std::abs(normal.dot(p - a)) / normal.norm()) : nearest;
}

double distance_to_surface(const Vector3d& point, const TriangleMesh& mesh) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles.rowwise())
    nearest = std::min(nearest, distance_to_triangle(point, mesh.positions.row(t[0]), mesh.positions.row(t[1]),
                                                     mesh.positions.row(t[2])));
  return nearest;
}

void require_inside(const Points& points, const Lattice& lattice, const VectorXi& hex, const char* what) {
  const auto outside = std::find(hex.begin(), hex.end(), -1);
  if (outside == hex.end()) return;
  const Eigen::Index p = outside - hex.begin();
  const Vector3d low = lattice.rest_positions.colwise().minCoeff(), high = lattice.rest_positions.colwise().maxCoeff();
  std::string value = fmt::format("({:g}, {:g}, {:g})", points(p, 0), points(p, 1), points(p, 2));
  std::string remedy = "give a point in one of its cells";
  if (!lattice.is_regular()) {
    const TriangleMesh surface = surface_of(lattice.rest_positions, lattice.hexes).mesh;
    const auto more = std::count(outside + 1, hex.end(), -1);
    value += fmt::format(", {:.4g} m from its nearest face", distance_to_surface(points.row(p), surface));
    if (more > 0) value += fmt::format(" (and {} more)", more);
    remedy = "give hexes that hold it";
  }
  throw Error(Fault::bad_data, {fmt::format("{} {}", what, p), "lies outside the cage", value,
                                fmt::format("the cage spans ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}); {}", low[0],
                                            low[1], low[2], high[0], high[1], high[2], remedy)});
}

void trilinear_weights(const double* s, double* weights) {
  const std::array<double, 2> x{1 - s[0], s[0]}, y{1 - s[1], s[1]}, z{1 - s[2], s[2]};
  for (int n = 0; n < 8; ++n) weights[n] = x[n >> 2] * y[n >> 1 & 1] * z[n & 1];
}

EmbeddedPoints weighted(const VectorXi& hex, const Points& local) {
  EmbeddedPoints points;
  points.hex = hex;
  points.weights.resize(hex.size(), 8);
  parallel_blocks(hex.size(), block_size, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index p = first; p < last; ++p) trilinear_weights(local.data() + 3 * p, points.weights.data() + 8 * p);
  });
  return points;
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

void evaluate(const Embedding& embedding, const std::vector<Polynomial>& polynomials, Eigen::Index first,
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

VectorXi find_hexes(const Points& points, const Lattice& lattice) {
  VectorXi hex;
  Points local;
  locate(points, lattice, hex, local);
  return hex;
}

EmbeddedPoints embed_points(const Points& points, const Lattice& lattice, const char* what) {
  VectorXi hex;
  Points local;
  locate(points, lattice, hex, local);
  require_inside(points, lattice, hex, what);
  return weighted(hex, local);
}

Embedding embed(const TriangleMesh& rest, const Lattice& lattice) {
  Embedding embedding;
  VectorXi& hex = embedding.hex;
  locate(rest.positions, lattice, hex, embedding.local);
  require_inside(rest.positions, lattice, hex, "vertex");

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

EmbeddedPoints points_of(const Embedding& embedding) {
  return weighted(embedding.hex, embedding.local);
}

void deform_positions(const Embedding& embedding, const Hexes& hexes, const Points& nodes, Points& out) {
  const Eigen::Index num_vertices = embedding.local.rows();
  if (out.rows() != num_vertices) out.resize(num_vertices, 3);

  std::vector<Polynomial> polynomials(embedding.used_hexes.size());
  parallel_blocks(Eigen::Index(polynomials.size()), block_size, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index i = first; i < last; ++i)
      polynomials[i] = trilinear_polynomial(hexes, embedding.used_hexes[i], nodes);
  });
  parallel_blocks(num_vertices, block_size, [&](Eigen::Index first, Eigen::Index last) {
    evaluate(embedding, polynomials, first, last, out.data());
  });
}

void deform(const Embedding& embedding, const Hexes& hexes, const Points& nodes, TriangleMesh& out) {
  const Eigen::Index num_vertices = embedding.local.rows();
  deform_positions(embedding, hexes, nodes, out.positions);
  if (out.normals.rows() != num_vertices) out.normals.resize(num_vertices, 3);
  parallel_blocks(num_vertices, block_size, [&](Eigen::Index first, Eigen::Index last) {
    compute_normals(embedding.fans, out.positions, first, last, out.normals);
  });
}

Points nodal_forces(const EmbeddedPoints& points, const Hexes& hexes, Eigen::Index num_nodes, const Points& forces) {
  Points nodal = Points::Zero(num_nodes, 3);
  for (Eigen::Index p = 0; p < points.size(); ++p)
    for (int n = 0; n < 8; ++n) nodal.row(hexes(points.hex[p], n)) += points.weights(p, n) * forces.row(p);
  return nodal;
}

Points deform_points(const EmbeddedPoints& points, const Hexes& hexes, const Points& nodes) {
  Points positions(points.size(), 3);
  parallel_blocks(points.size(), block_size, [&](Eigen::Index first, Eigen::Index last) {
    for (Eigen::Index p = first; p < last; ++p) {
      Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
      for (int n = 0; n < 8; ++n) x += points.weights(p, n) * nodes.row(hexes(points.hex[p], n));
      positions.row(p) = x;
    }
  });
  return positions;
}

}  // namespace umax
