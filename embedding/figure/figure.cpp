#include "embedding/figure/figure.h"

#include <tbb/parallel_for.h>

#include <string>

#include "core/base/error.h"
#include "embedding/figure/figure_shape.h"
#include "embedding/figure/figure_surface.h"

namespace umax {
namespace {

void validate(const FigureOptions& options) {
  if (!(options.height > 0 && options.height < 1e6)) {
    throw Error(Fault::bad_data, {"figure", "the height must be positive", std::to_string(options.height) + " m",
                                  "give a height such as 2 m"});
  }
  if (!(options.cell_size >= 4e-3 && options.cell_size <= 20e-3)) {
    throw Error(Fault::bad_data, {"figure", "the cell size must be between 4 mm and 20 mm",
                                  std::to_string(options.cell_size) + " m", "leave it at 6.5 mm"});
  }
}

void paint(const figure::Anatomy& anatomy, TriangleMesh& mesh) {
  mesh.colors.resize(mesh.num_vertices(), 3);
  tbb::parallel_for(Eigen::Index(0), mesh.num_vertices(), [&](Eigen::Index v) {
    mesh.colors.row(v) =
        figure::paint(anatomy, mesh.positions.row(v).transpose(), mesh.normals.row(v).transpose()).transpose();
  });
}

/// Scales to the height asked for, with the soles on y = 0.
void place(double height, TriangleMesh& mesh) {
  const double bottom = mesh.positions.col(1).minCoeff(), top = mesh.positions.col(1).maxCoeff();
  mesh.positions.col(1).array() -= bottom;
  mesh.positions *= height / (top - bottom);
}

}  // namespace

TriangleMesh make_figure(const FigureOptions& options) {
  validate(options);
  const figure::Anatomy anatomy = figure::make_anatomy();
  const auto distance = [&](const Vector3d& p, double reach) {
    return figure::distances(anatomy, figure::posed(p), reach).all;
  };
  TriangleMesh mesh = level_set_surface(
      distance,
      {.min = {-1.1, -0.05, -1.3}, .max = {1.1, 2.15, 0.75}, .cell_size = options.cell_size, .fine = figure::on_face});
  paint(anatomy, mesh);
  place(options.height, mesh);
  return mesh;
}

}  // namespace umax
