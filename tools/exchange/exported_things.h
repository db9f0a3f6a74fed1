// What of a scene is exported: its bodies and obstacles as surfaces that move, in the axes and the unit of the export.
#pragma once

#include <optional>

#include "embedding/caches/moving_surface.h"
#include "embedding/loose_vertices.h"
#include "tools/exchange/export_format.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

/// What the user wants exported, and how.
struct ExportOptions {
  ExportFormat format = ExportFormat::pc2;
  /// Names of bodies, and of obstacles ("obstacle.NAME" where a body has the name, too); empty: all.
  std::vector<std::string> things = {};
  bool z_up = false;       // else y
  double scale = 1;        // [-] on all lengths: 100 for centimetres
  bool overwrite = false;  // files that are there
};

/// A picture that a material shows: a file of its own, or inside of the mesh's; neither: none.
struct ExportedTexture {
  std::filesystem::path file;
  const std::string* bytes = nullptr;  // of the simulation's shape

  bool is_there() const { return bytes || !file.empty(); }
};

/// A body or an obstacle.
struct ExportedThing {
  std::string stem;                           // of its files: "cow", "obstacle.plate"
  std::optional<std::size_t> body, obstacle;  // one of them: its index in the simulation
  MovingSurface surface;                      // vertices: all of the mesh file, in its order
  std::vector<ExportedTexture> textures;      // of each of its materials
  std::vector<int> vertex_in_file;            // #V of the body's own vertices their places among the surface's; empty:
                                              // they are those
  std::vector<int> loose_in_file;             // of the file's other vertices
  LooseVertices loose;                        // how those go with the body
};

/// The bodies, and the obstacles that are visible; those alone that the options name, where they do. A half space is a
/// square around the bodies. Throws Error (usage) for a name that the scene does not have.
std::vector<ExportedThing> things_to_export(const Simulation& simulation, const ExportOptions& options);

/// The camera in the axes and the unit of the export.
ClipCamera exported_camera(const Camera& camera, const RenderDescription& render, const ExportOptions& options);

/// The thing in a state, with what the format holds. Throws Error (bad_data) where a coordinate is beyond what it can
/// hold.
SurfaceFrame sample(const Simulation& simulation, const ExportedThing& thing, const ExportOptions& options, int frame,
                    const State& state);

}  // namespace umax
