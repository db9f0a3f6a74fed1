// The surface without the creases that trilinear interpolation has where the cells of a bent cage meet: for pictures.
//
//   x(s) = sum over the cell's nodes n, and over which of the three axes are differentiated, of
//          H_i(s1) H_j(s2) H_k(s3) d_n        H: cubic Hermite polynomials of value or slope
//
// d_n: the node's place x_n, and its differences Dx, Dy, Dz, Dxy, Dxz, Dyz, Dxyz [m per cell]: each the mean over the
// node's sides (quadrants, octants) that have a cell, of the difference along that cell's edges. Inside of a cage that is
// the tensor product of Catmull-Rom splines; at its border it needs no cells that are not there, and parts of the cage
// that share no node do not touch each other's surface. Cells that share a face share all of its data: the surface is C1.
// It passes through the nodes, and is exact for affine motion.
#pragma once

#include "embedding/embedding.h"

namespace umax {

/// deform() with this kernel. Only for regular lattices. The same bits for any number of threads.
void deform_smoothly(const Embedding& embedding, const Lattice& lattice, const Points& nodes, TriangleMesh& out);

/// Positions of points by the hex that holds them and their coordinates there, #P x 3 [m].
Points smooth_positions(const VectorXi& hex, const Points& local, const Lattice& lattice, const Points& nodes);

}  // namespace umax
