// From a scene to what can be simulated and drawn: meshes read and placed, cages built, surfaces embedded, model made.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "embedding/cage/voxelize.h"
#include "embedding/embedding.h"
#include "embedding/hex_files/hex_mesh_io.h"
#include "embedding/maps/factor_map.h"
#include "embedding/surface/mesh_report.h"
#include "render/image/image.h"
#include "scenes/scene.h"
#include "tools/setup/state_file.h"

namespace umax {

/// Hexes from a file that are a body's cage, in world coordinates at time 0.
struct PlacedHexes {
  HexMesh mesh;                    // nodes in metres
  std::vector<int> surface_nodes;  // #V node of every vertex of the body's surface; empty: the surface is another's
  bool are_the_body() const { return !surface_nodes.empty(); }
};

/// A body's shape, before it has a cage.
struct PlacedMesh {
  TriangleMesh mesh;                                              // world coordinates at time 0 [m], with normals
  std::filesystem::path texture;                                  // colour texture; may be empty
  std::vector<std::string> notes;                                 // what the file's reader found
  int num_parts = 1;                                              // objects in the file
  std::optional<PlacedHexes> hexes = std::nullopt;                // of the mesh file or of cage.mesh
  Eigen::Affine3d world_from_file = Eigen::Affine3d::Identity();  // from the mesh file's own coordinates [m]
};

/// A map as it acts on a body's hexes.
struct BodyMap {
  std::string key;     // "limit.map"
  std::string source;  // its file, for messages
  HexFactors hexes;
};

/// A body with what is needed to draw it. Its nodes and hexes are a range of the model's.
struct BodySetup {
  std::string name;
  PlacedMesh shape;
  Lattice lattice;
  CageReport cage;
  Embedding embedding;
  Eigen::Index first_node = 0, first_hex = 0;  // in the model
  std::shared_ptr<const Image> texture;        // linear; null: none
  std::optional<BodyMap> young_map = std::nullopt, limit_map = std::nullopt;
};

struct ObstacleSetup {
  std::shared_ptr<const TriangleMesh> mesh;  // in the obstacle's own frame [m]; null: a half space
};

struct Simulation {
  Scene scene;
  std::vector<BodySetup> bodies;         // in the order of the scene's
  std::vector<ObstacleSetup> obstacles;  // likewise
  Model model;
  StepOptions options;
  EmbeddedPoints probes;              // in the order of the scene's; hexes of the model
  Digest digest;                      // of what decides the states
  std::vector<std::string> warnings;  // for the user: faults of meshes and what was done, starts in penetration
  int last_frame() const { return scene.clip.frames; }
};

/// Reads or makes the body's mesh and puts it where the scene says, but for drop_height. Throws Error naming the body.
PlacedMesh place_body(const BodyDescription& body);

/// The cage options that a scene's cage key means; not for cage.mesh.
CageOptions cage_options(const CageDescription& cage);

/// The model's obstacle and the mesh to draw it. Throws Error naming the obstacle.
Obstacle make_obstacle(const ObstacleDescription& description, ObstacleSetup& setup);

/// Called with the bodies so far whenever one has its cage; may throw before more memory is taken.
using CageWatch = std::function<void(const std::vector<BodySetup>&)>;

/// Throws Error (bad_data, not_found) that names the body, obstacle or probe and what is wrong.
Simulation set_up(const Scene& scene, const CageWatch& watch = {});

/// Current positions of the probes, one after the other [m].
std::vector<Vector3d> probe_positions(const Simulation& simulation, const Points& nodes);

/// The names of the scene's probes.
std::vector<std::string> probe_names(const Scene& scene);

}  // namespace umax
