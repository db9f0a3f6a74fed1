#include "tools/setup/body_shape.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "embedding/figure/figure.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/contact_surface.h"
#include "embedding/surface/hex_faces.h"
#include "embedding/surface/shapes.h"
#include "tools/setup/named_error.h"

namespace umax {
namespace {

OwnShape read_hexes(const std::filesystem::path& path) {
  HexMesh hexes = load_hex_mesh(path);
  HexSurface surface = surface_of(hexes.nodes, hexes.hexes);
  OwnShape shape;
  shape.mesh = std::move(surface.mesh);
  shape.notes = hexes.notes;
  shape.hexes = PlacedHexes{std::move(hexes), std::move(surface.nodes)};
  return shape;
}

OwnShape read_mesh(const std::filesystem::path& path) {
  MeshFile file = load_mesh(path);
  OwnShape shape;
  shape.mesh = std::move(file.mesh);
  shape.materials = std::move(file.materials);
  shape.embedded_textures = std::move(file.embedded_textures);
  shape.notes = std::move(file.notes);
  shape.num_parts = file.num_parts;
  shape.unit = file.unit;
  shape.up = file.up;
  shape.vertex_in_file = std::move(file.vertex_in_file);
  shape.loose_vertices = std::move(file.loose_vertices);
  shape.loose_colors = std::move(file.loose_colors);
  return shape;
}

OwnShape shape_of(const MeshSource& source) {
  OwnShape shape = is_hex_mesh_file(source.path) ? read_hexes(source.path) : read_mesh(source.path);
  if (source.unit) shape.unit = source.unit;
  if (source.up) shape.up = source.up;
  return shape;
}
OwnShape shape_of_mesh(TriangleMesh mesh) {
  OwnShape shape;
  shape.mesh = std::move(mesh);
  return shape;
}
OwnShape shape_of(const BoxShape& box) {
  return shape_of_mesh(make_box(box.size));
}
OwnShape shape_of(const SphereShape& sphere) {
  return shape_of_mesh(make_sphere(sphere.radius));
}
OwnShape shape_of(const CylinderShape& cylinder) {
  return shape_of_mesh(make_cylinder(cylinder.radius, cylinder.length));
}
OwnShape shape_of(const RingShape& ring) {
  return shape_of_mesh(make_ring(ring.radius, ring.thickness));
}
OwnShape shape_of(const FigureShape&) {
  return shape_of_mesh(make_figure());
}

bool are_same(const MeshSource& a, const MeshSource& b) {
  return a.path == b.path && a.unit == b.unit && a.up == b.up;
}
bool are_same(const BoxShape& a, const BoxShape& b) {
  return a.size == b.size;
}
bool are_same(const SphereShape& a, const SphereShape& b) {
  return a.radius == b.radius;
}
bool are_same(const CylinderShape& a, const CylinderShape& b) {
  return a.radius == b.radius && a.length == b.length;
}
bool are_same(const RingShape& a, const RingShape& b) {
  return a.radius == b.radius && a.thickness == b.thickness;
}
bool are_same(const FigureShape&, const FigureShape&) {
  return true;
}
template <class A, class B>
bool are_same(const A&, const B&) {
  return false;
}

/// Reads cage.mesh. Its notes become the shape's.
void read_cage_mesh(const MeshSource& source, PlacedMesh& shape) {
  shape.hexes = PlacedHexes{load_hex_mesh(source.path), {}};
  shape.notes.insert(shape.notes.end(), shape.hexes->mesh.notes.begin(), shape.hexes->mesh.notes.end());
}

/// Vertices that are nodes stand where their nodes stand, to the last bit.
void tie_to_nodes(PlacedMesh& shape) {
  if (!shape.hexes) return;
  const std::vector<int>& nodes = shape.hexes->surface_nodes;
  for (std::size_t v = 0; v < nodes.size(); ++v)
    shape.mesh.positions.row(Eigen::Index(v)) = shape.hexes->mesh.nodes.row(nodes[v]);
}

}  // namespace

std::shared_ptr<const OwnShape> own_shape(const BodySource& source, ShapeLibrary& library) {
  const auto found = std::find_if(library.shapes.begin(), library.shapes.end(), [&](const ShapeLibrary::Shape& shape) {
    return std::visit([](const auto& a, const auto& b) { return are_same(a, b); }, shape.source, source);
  });
  if (found != library.shapes.end()) return found->own;
  auto own = std::make_shared<OwnShape>(std::visit([](const auto& kind) { return shape_of(kind); }, source));
  own->mesh.normals.resize(0, 3);
  library.shapes.push_back({source, own});
  return own;
}

PlacedMesh place_body(const BodyDescription& body, ShapeLibrary& library) {
  return named("body." + body.name, [&] {
    const std::shared_ptr<const OwnShape> own = own_shape(body.source, library);
    PlacedMesh shape{
        .mesh = own->mesh, .notes = own->notes, .num_parts = own->num_parts, .hexes = own->hexes, .own = own};
    if (const auto* cage = std::get_if<MeshSource>(&body.cage.size)) read_cage_mesh(*cage, shape);
    const Placed placed = place(shape.mesh,
                                {.unit = own->unit,
                                 .up = own->up,
                                 .height = body.height,
                                 .scale = body.scale,
                                 .rotation_degrees = body.rotation_degrees,
                                 .position = body.position},
                                shape.hexes ? &shape.hexes->mesh.nodes : nullptr);
    shape.world_from_file = placed.placed_from_own;
    shape.scale = placed.scale;
    tie_to_nodes(shape);
    return shape;
  });
}

void move_shape(const Vector3d& by, PlacedMesh& shape) {
  shape.world_from_file.pretranslate(by);
  for (int axis = 0; axis < 3; ++axis) {
    if (by[axis] == 0) continue;
    shape.mesh.positions.col(axis).array() += by[axis];
    if (shape.hexes) shape.hexes->mesh.nodes.col(axis).array() += by[axis];
  }
  tie_to_nodes(shape);
}

std::shared_ptr<const RestSurface> rest_surface(const PlacedMesh& shape, ShapeLibrary& library, double& scale) {
  const auto found = std::find_if(library.surfaces.begin(), library.surfaces.end(),
                                  [&](const ShapeLibrary::Surface& surface) { return surface.own == shape.own.get(); });
  scale = found == library.surfaces.end() ? 1 : shape.scale / found->scale;
  if (found != library.surfaces.end()) return found->surface;
  const TriangleMesh border = contact_surface(shape.own->mesh);
  std::shared_ptr<const RestSurface> surface;
  if (border.num_triangles() > 0)
    surface = std::make_shared<const RestSurface>(make_rest_surface(shape.scale * border.positions, border.triangles));
  library.surfaces.push_back({shape.own.get(), shape.scale, surface});
  return surface;
}

Pose rest_pose(const PlacedMesh& shape) {
  return {shape.world_from_file.linear() / shape.scale, shape.world_from_file.translation()};
}

}  // namespace umax
