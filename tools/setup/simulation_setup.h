// From a scene to what can be simulated and drawn: meshes read and placed, cages built, surfaces embedded, model made.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "embedding/cage/voxelize.h"
#include "embedding/embedding.h"
#include "embedding/maps/factor_map.h"
#include "embedding/surface/mesh_report.h"
#include "render/image/image.h"
#include "scenes/scene.h"
#include "tools/setup/body_shape.h"
#include "tools/setup/obstacle_setup.h"
#include "tools/setup/pull_file.h"
#include "tools/setup/state_file.h"

namespace umax {

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
  std::shared_ptr<const Embedding> embedding;  // shared by bodies that differ in their place alone
  Eigen::Index first_node = 0, first_hex = 0;  // in the model
  Look look;                                   // with its pictures
  std::optional<BodyMap> young_map = std::nullopt, limit_map = std::nullopt;
  std::vector<std::string> notes = {};  // for the user: what pins hold
};

struct Simulation {
  Scene scene;
  std::vector<BodySetup> bodies;         // in the order of the scene's
  std::vector<ObstacleSetup> obstacles;  // likewise
  Model model;
  StepOptions options;                // but for what changes from step to step: tools/setup/stepping.h
  RecordedPulls pulls;                // of the scene's file
  EmbeddedPoints probes;              // in the order of the scene's; hexes of the model
  Digest digest;                      // of what decides the states
  std::vector<std::string> warnings;  // for the user: faults of meshes and what was done, starts in penetration
  int last_frame() const { return scene.clip.frames; }
};

/// The mesh of an obstacle that has one as it is at a time [s], in the obstacle's own frame [m], with normals.
std::shared_ptr<const TriangleMesh> obstacle_mesh(const Simulation& simulation, std::size_t obstacle, double time);

/// Called with the bodies so far whenever one has its cage; may throw before more memory is taken.
using CageWatch = std::function<void(const std::vector<BodySetup>&)>;

/// Throws Error (bad_data, not_found) that names the body, obstacle or probe and what is wrong.
Simulation set_up(const Scene& scene, const CageWatch& watch = {});

/// The same with what earlier calls have left in the library, and leaves more there.
Simulation set_up(const Scene& scene, ShapeLibrary& library, const CageWatch& watch = {});

/// Simulation::digest of a simulation whose scene and model have been changed alike.
Digest digest_of(const Simulation& simulation);

/// Current positions of the probes, one after the other [m].
std::vector<Vector3d> probe_positions(const Simulation& simulation, const Points& nodes);

/// The names of the scene's probes.
std::vector<std::string> probe_names(const Scene& scene);

}  // namespace umax
