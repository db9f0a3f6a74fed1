// The shapes of bodies: read or made, once for all bodies that have one in common, and put where the scene says.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"
#include "core/model/rest_surface.h"
#include "embedding/cage/voxelize.h"
#include "embedding/embedding.h"
#include "embedding/hex_files/hex_mesh_io.h"
#include "embedding/mesh_record/mesh_file.h"
#include "embedding/surface/placement.h"
#include "render/image/image.h"
#include "scenes/scene.h"

namespace umax {

/// Hexes from a file that are a body's cage.
struct PlacedHexes {
  HexMesh mesh;                    // nodes where the body's mesh is, and in its unit
  std::vector<int> surface_nodes;  // #V node of every vertex of the body's surface; empty: the surface is another's
  bool are_the_body() const { return !surface_nodes.empty(); }
};

/// A shape as its file or the scene's key gives it, in its own unit and axes.
struct OwnShape {
  TriangleMesh mesh;                           // without normals: deform() makes them
  std::vector<MeshMaterial> materials;         // that mesh.materials counts; empty: none
  std::vector<std::string> embedded_textures;  // bytes of pictures, which materials name
  std::vector<std::string> notes;              // what the file's reader found
  int num_parts = 1;                           // objects in the file
  std::optional<PlacedHexes> hexes;            // of a file of hexes, whose surface is the mesh
  std::optional<double> unit;                  // [m] where the scene or the file says
  std::optional<std::string> up;
  std::vector<int> vertex_in_file;  // #V place of each vertex in the file's order; empty: all are as there
  Points loose_vertices;            // #L x 3 vertices of the file that no triangle has, in its order
  Points loose_colors;              // #L x 3, or empty
};

/// What the bodies of a scene have in common: each shape is read once, and has one surface. Given to several calls of
/// set_up(), one after the other, it saves those of scenes that differ in other things the same work: each is set up as if
/// it were alone.
struct ShapeLibrary {
  struct Shape {
    BodySource source;
    std::shared_ptr<const OwnShape> own;
  };
  struct Surface {
    const OwnShape* own = nullptr;
    double scale = 0;  // [m] of one of the mesh's units: that of the first body which asked
    std::shared_ptr<const RestSurface> surface;
  };
  struct Texture {
    std::filesystem::path path;
    const OwnShape* own = nullptr;  // the shape in whose file the picture is, or null
    int place = -1;                 // of own->embedded_textures
    std::shared_ptr<const Image> image;
  };
  struct Cage {
    std::shared_ptr<const OwnShape> own;
    Eigen::Affine3d world_from_file;
    CageDescription description;
    Lattice lattice;
    CageReport report;
    std::shared_ptr<const Embedding> embedding;
  };
  bool keeps_cages = false;  // for the scenes after this one
  std::vector<Shape> shapes = {};
  std::vector<Surface> surfaces = {};  // of one scene: as large as its first body of that shape
  std::vector<Cage> cages = {};
  std::vector<Texture> textures = {};
};

/// Reads or makes the shape unless the library has it. Throws Error (bad_data, not_found).
std::shared_ptr<const OwnShape> own_shape(const BodySource& source, ShapeLibrary& library);

/// A body's shape, before it has a cage.
struct PlacedMesh {
  TriangleMesh mesh;                                              // world coordinates at time 0 [m], without normals
  std::vector<std::string> notes;                                 // what the file's reader found
  int num_parts = 1;                                              // objects in the file
  std::optional<PlacedHexes> hexes = std::nullopt;                // of the mesh file or of cage.mesh, likewise placed
  Eigen::Affine3d world_from_file = Eigen::Affine3d::Identity();  // from the mesh file's own coordinates [m]
  double scale = 1;                                               // [m] of one of its units
  std::shared_ptr<const OwnShape> own = nullptr;                  // that was placed
};

/// Reads or makes the body's mesh and puts it where the scene says, but for drop_height. Throws Error naming the body.
PlacedMesh place_body(const BodyDescription& body, ShapeLibrary& library);

/// Moves the shape along.
void move_shape(const Vector3d& by, PlacedMesh& shape);

/// What others hit of the shape: its surface, in metres but not turned and not moved, at the size of the first body that
/// asked. Null: it has no inside. scale: of this shape over that one.
std::shared_ptr<const RestSurface> rest_surface(const PlacedMesh& shape, ShapeLibrary& library, double& scale);

/// Where that surface's frame is in the world at time 0.
Pose rest_pose(const PlacedMesh& shape);

}  // namespace umax
