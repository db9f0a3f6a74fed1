// Smooth vertex normals of a surface that deforms, weighted by triangle area.
#pragma once

#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

/// For every vertex the rim of the triangles that share its normal, as chains of vertices: two neighbours in a chain
/// and the vertex make one triangle. Entries of vertex v: entries[offsets[v]] .. entries[offsets[v + 1] - 1]; ~i
/// (negative) begins a new chain at vertex i.
///
/// Vertices that share a position share their triangles where these meet at less than crease_degrees, so that seams of
/// texture coordinates and facets of STL files come out smooth while hard edges of split vertices stay hard. Where more
/// than 2,048 triangles meet, vertices keep to their own.
struct VertexFans {
  std::vector<int> order;    // #V vertices along a space-filling curve
  std::vector<int> offsets;  // #V + 1
  std::vector<int> entries;
};
VertexFans make_vertex_fans(const TriangleMesh& mesh, double crease_degrees = 60);

/// Unit normals of the vertices order[first] .. order[last - 1]; a vertex without area around it gets +Y. positions and
/// normals: #V x 3, already sized. Independent of how the range is split.
void compute_normals(const VertexFans& fans, const Points& positions, Eigen::Index first, Eigen::Index last,
                     Points& normals);

/// Fills mesh.normals, with all threads.
void compute_normals(TriangleMesh& mesh, double crease_degrees = 60);

}  // namespace umax
