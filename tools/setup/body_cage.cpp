#include "tools/setup/body_cage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <variant>

#include "core/base/error.h"
#include "core/model/obstacle.h"
#include "embedding/cage/hex_cage.h"
#include "embedding/embedding.h"
#include "tools/setup/named_error.h"

namespace umax {
namespace {

Vector3d lowest(const TriangleMesh& mesh) {
  return mesh.positions.colwise().minCoeff().transpose();
}
Vector3d highest(const TriangleMesh& mesh) {
  return mesh.positions.colwise().maxCoeff().transpose();
}

/// Moves the mesh up or down until its lowest point is drop_height above the highest obstacle below it.
void apply_drop_height(double drop_height, const std::vector<Obstacle>& obstacles, PlacedMesh& shape) {
  const TriangleMesh& mesh = shape.mesh;
  double top = -std::numeric_limits<double>::infinity();
  for (const Obstacle& obstacle : obstacles)
    top = std::max(top, highest_point_below(obstacle, 0, lowest(mesh), highest(mesh)));
  if (!std::isfinite(top))
    throw Error(Fault::bad_data, {.where = "drop_height",
                                  .what = "there is no obstacle below the body",
                                  .value = fmt::format("{} m", drop_height),
                                  .remedy = "add [obstacle.ground], or give position instead"});
  move_shape(Vector3d(0, top + drop_height - lowest(mesh).y(), 0), shape);
}

bool has_same_cage(const CageDescription& a, const CageDescription& b) {
  if (std::holds_alternative<MeshSource>(a.size) || std::holds_alternative<MeshSource>(b.size)) return false;
  const CageOptions options_a = cage_options(a), options_b = cage_options(b);
  return options_a.size == options_b.size && options_a.whole_box == options_b.whole_box;
}

/// The first of the bodies so far that differs from the shape in its place alone; null: none.
const BodySetup* find_twin(const Scene& scene, const std::vector<BodySetup>& caged, const BodyDescription& description,
                           const PlacedMesh& shape) {
  if (shape.hexes) return nullptr;
  for (std::size_t i = 0; i < caged.size(); ++i)
    if (caged[i].shape.own == shape.own && caged[i].shape.world_from_file.linear() == shape.world_from_file.linear() &&
        has_same_cage(scene.bodies[i].cage, description.cage))
      return &caged[i];
  return nullptr;
}

/// What is known of the very body from an earlier scene; null: nothing.
const ShapeLibrary::Cage* find_cage(const ShapeLibrary& library, const BodyDescription& description,
                                    const PlacedMesh& shape) {
  for (const ShapeLibrary::Cage& cage : library.cages)
    if (cage.own == shape.own && cage.world_from_file.matrix() == shape.world_from_file.matrix() &&
        has_same_cage(cage.description, description.cage))
      return &cage;
  return nullptr;
}

/// The twin's cage, moved.
void take_cage(const BodySetup& twin, BodySetup& setup) {
  const Vector3d by = setup.shape.world_from_file.translation() - twin.shape.world_from_file.translation();
  setup.lattice = make_lattice(twin.lattice.cells, twin.lattice.origin + by, twin.lattice.cell_size);
  setup.lattice.filled_fraction = twin.lattice.filled_fraction;
  setup.cage = twin.cage;
  setup.embedding = twin.embedding;
}

}  // namespace

CageOptions cage_options(const CageDescription& cage) {
  CageOptions options{.whole_box = cage.clip == CageDescription::Clip::box};
  if (const int* count = std::get_if<int>(&cage.size)) options.size = *count;
  if (const Vector3i* grid = std::get_if<Vector3i>(&cage.size)) options.size = *grid;
  if (const double* edge = std::get_if<double>(&cage.size)) options.size = *edge;
  return options;
}

BodySetup cage_body(const Scene& scene, const std::vector<BodySetup>& caged, const std::vector<Obstacle>& obstacles,
                    ShapeLibrary& library) {
  const BodyDescription& description = scene.bodies[caged.size()];
  BodySetup setup{.name = description.name,
                  .shape = place_body(description, library),
                  .lattice = {},
                  .cage = {},
                  .embedding = {},
                  .look = {}};
  named("body." + description.name, [&] {
    if (description.drop_height) apply_drop_height(*description.drop_height, obstacles, setup.shape);
    const PlacedMesh& shape = setup.shape;
    if (const BodySetup* twin = find_twin(scene, caged, description, shape)) {
      take_cage(*twin, setup);
      return 0;
    }
    if (const ShapeLibrary::Cage* known = shape.hexes ? nullptr : find_cage(library, description, shape)) {
      setup.lattice = known->lattice;
      setup.cage = known->report;
      setup.embedding = known->embedding;
      return 0;
    }
    setup.lattice = shape.hexes ? make_hex_cage(shape.mesh, shape.hexes->mesh.nodes, shape.hexes->mesh.hexes,
                                                {.is_the_body = shape.hexes->are_the_body()}, &setup.cage)
                                : voxelize(shape.mesh, cage_options(description.cage), &setup.cage);
    setup.embedding = std::make_shared<const Embedding>(embed(setup.shape.mesh, setup.lattice));
    if (library.keeps_cages && !shape.hexes)
      library.cages.push_back(
          {shape.own, shape.world_from_file, description.cage, setup.lattice, setup.cage, setup.embedding});
    return 0;
  });
  return setup;
}

}  // namespace umax
