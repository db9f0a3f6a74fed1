#include "tests/support/touchable.h"

#include "embedding/surface/shapes.h"

namespace umax::test {
namespace {

std::shared_ptr<const RestSurface> surface_of(TriangleMesh mesh, const Vector3d& centre) {
  mesh.positions.rowwise() += centre.transpose();
  return std::make_shared<const RestSurface>(make_rest_surface(mesh.positions, mesh.triangles));
}

}  // namespace

Body touchable_block(const std::string& name, const Vector3i& num_cells, const Vector3d& origin, double cell_size,
                     int points_per_edge) {
  Body body = make_block(num_cells, origin, cell_size, points_per_edge);
  body.name = name;
  const Vector3d size = cell_size * num_cells.cast<double>();
  body.rest_surface = surface_of(make_box(size), origin + 0.5 * size);
  return body;
}

Body touchable_ball(const std::string& name, int cells, const Vector3d& centre, double radius) {
  const double cell_size = 2 * radius / cells;
  Body body = make_block(Vector3i::Constant(cells), centre - Vector3d::Constant(radius), cell_size, 2);
  body.name = name;
  const TriangleMesh mesh = umax::make_sphere(radius, 3);
  body.surface_rest = mesh.positions.rowwise() + centre.transpose();
  body.surface = embed_in_box(body.lattice, Vector3i::Constant(cells), body.surface_rest);
  body.rest_surface = surface_of(mesh, centre);
  return body;
}

StepOptions without_gravity() {
  StepOptions options;
  options.gravity.setZero();
  return options;
}

Points nodes_of(const Model& model, const Points& of_all, int body) {
  return of_all.middleRows(model.bodies[body].first_node, model.bodies[body].num_nodes);
}

double lowest_of(const Model& model, const State& state, int body) {
  return nodes_of(model, state.positions, body).col(1).minCoeff();
}

double highest_of(const Model& model, const State& state, int body) {
  return nodes_of(model, state.positions, body).col(1).maxCoeff();
}

}  // namespace umax::test
