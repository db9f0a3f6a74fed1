// The paper's armadillo for tests tagged [models]: 365 hexes, 43,243 vertices.
#pragma once

#include "core/model/model.h"
#include "embedding/cage/voxelize.h"
#include "embedding/embedding.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/placement.h"
#include "tests/support/model_file.h"

namespace umax::test {

/// 2 m tall, its lowest vertex at the given height [m].
inline Body make_armadillo(double height_above_ground) {
  TriangleMesh mesh = load_mesh(model_file("armadillo.obj")).mesh;
  place(mesh, {.height = 2.0});
  mesh.positions.col(1).array() += height_above_ground - mesh.positions.col(1).minCoeff();
  Body body;
  body.name = "armadillo";
  body.lattice = voxelize(mesh, {.size = 365});
  body.material = {.young = 500e3, .poisson = 0.3, .density = 500};
  body.surface = embed_points(mesh.positions, body.lattice);
  body.surface_rest = mesh.positions;
  return body;
}

}  // namespace umax::test
