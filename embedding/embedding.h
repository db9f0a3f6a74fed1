// A surface that rides in the cage: every vertex keeps its place inside its hex while the hexes deform.
//
// [PPO13] Sect. 4.1   x(p) = sum_n N_n(s_p) x_n
//
// x(p): vertex p now [m];  s_p: its rest coordinates in its hex [-];  N_n, x_n: shape function and place of node n
#pragma once

#include <vector>

#include "core/base/triangle_mesh.h"
#include "core/model/embedded_points.h"
#include "core/model/lattice.h"
#include "embedding/surface/normals.h"

namespace umax {

struct Embedding {
  VectorXi hex;                 // #V that holds every vertex
  Points local;                 // #V x 3 coordinates in the vertex's hex, in [0, 1] (1e-9 beyond on faces)
  std::vector<int> slot;        // #V index into used_hexes
  std::vector<int> used_hexes;  // hexes that hold a vertex, ascending
  VertexFans fans;              // whose triangles make each vertex's normal
};

/// The hex that holds each point, the lowest on a shared face; -1: none.
VectorXi find_hexes(const Points& points, const Lattice& lattice);

/// Where each point lies in a lattice, regular or not; on a shared face the hex with the lowest index. Throws Error
/// (bad_data) that names the first point outside the cage (and, of an irregular one, how far). `what` names the points
/// in that message.
EmbeddedPoints embed_points(const Points& points, const Lattice& lattice, const char* what = "point");

/// Ties a mesh at rest to the lattice. Throws as embed_points() does.
Embedding embed(const TriangleMesh& rest, const Lattice& lattice);

/// The vertices with their trilinear weights.
EmbeddedPoints points_of(const Embedding& embedding);

/// Positions and unit normals of the surface for node positions (#N x 3 [m]). Only out.positions and out.normals are
/// written (and sized on first use). The same bits for any number of threads.
void deform(const Embedding& embedding, const Hexes& hexes, const Points& nodes, TriangleMesh& out);

/// The positions alone, #V x 3 [m] (sized on first use); of node velocities, the vertices' velocities [m/s]. The same bits
/// as deform()'s.
void deform_positions(const Embedding& embedding, const Hexes& hexes, const Points& nodes, Points& out);

/// Forces on embedded points, #P x 3 [N], as they reach the nodes: #N x 3 [N], which do the same work.
Points nodal_forces(const EmbeddedPoints& points, const Hexes& hexes, Eigen::Index num_nodes, const Points& forces);

/// Current positions of embedded points, #P x 3 [m].
Points deform_points(const EmbeddedPoints& points, const Hexes& hexes, const Points& nodes);

}  // namespace umax
