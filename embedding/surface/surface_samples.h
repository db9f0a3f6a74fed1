// Points on the edges and faces of triangles that are large beside what is to be felt of them, and on sharp ridges: a
// surface that touches by points alone is felt no finer than they lie.
//
// Spacing along an edge  s = min(S, 4 d / |n1 - n2|)  of a ridge,  S  of a groove or a flat
//
// S: largest spacing [cells], along each direction in what a cell measures there: a surface bends no finer than its cage
// does, and cells may be a hundred times longer than high;  n1, n2: normals of the edge's triangles (unit)
// d: depth [m] that another edge as sharp, across this one, may have midway between two points: |n1 - n2| / 2 is the
//    sine of the faces' slopes away from the ridge, and s / 2 times it that depth
//
// Triangles with edges longer than S get points on all their edges and within. Between smaller ones only sharp edges
// (normals 29 degrees apart) of more than S / 2 do: a finer surface is felt by its vertices.
#pragma once

#include "core/model/rest_surface.h"

namespace umax {

struct SurfaceSampling {
  double spacing = 0.25;      // [cells] S; triangles with longer edges are large. Halving it: four times as many points
  double ridge_depth = 4e-3;  // [m] d, more than 0. Halving it: twice as many points along ridges
  Eigen::Index num_given = 0;                // the first vertices of the surface that are points already
  Matrix3d to_cells = Matrix3d::Identity();  // [1/m] turns vectors of the surface into multiples of a cell's edges
};

/// Inner points of edges that are longer than their spacing, each edge once; points within large triangles' faces;
/// corners that are not given. #P x 3 [m]; none where the surface is fine enough.
Points sample_between_vertices(const RestSurface& surface, const SurfaceSampling& sampling);

}  // namespace umax
