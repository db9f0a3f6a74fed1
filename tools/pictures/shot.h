// One picture's worth of a run: deformed bodies, obstacles, lights, sky and camera, as the renderers take it.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "render/scene/render_scene.h"
#include "tools/pictures/heat.h"
#include "tools/setup/camera_framing.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

/// What stays the same in all pictures of a run.
struct Stage {
  Sky sky;
  std::shared_ptr<const TriangleMesh> ground;   // square that half spaces are drawn as
  std::vector<std::pair<int, int>> cage_edges;  // the cage's outer edges, nodes of the model
  std::optional<Legend> legend;                 // of the heat map
};

/// box: around the motion; the ground reaches far beyond it. range: of the motion, for heat maps. Throws Error when the
/// sky's picture cannot be read.
Stage make_stage(const Simulation& simulation, const Box& box, const HeatRange& range = {});

/// Vertices of a body's surface as physics knows it, #V x 3 [m], of the model's nodes.
Points surface_points(const BodySetup& body, const Points& nodes);

/// Box around a body's surface, of the model's nodes; around the surfaces of all bodies.
Box box_of(const BodySetup& body, const Points& nodes);
Box box_of(const Simulation& simulation, const Points& nodes);

/// The renderers' scene at the state's time.
RenderScene make_shot(const Simulation& simulation, const Stage& stage, const State& state, const Camera& camera);

/// The same with other values of all hexes than render.heatmap's, to be read from the stage's legend.
RenderScene make_shot(const Simulation& simulation, const Stage& stage, const State& state, const Camera& camera,
                      const VectorXd& values);

/// The surface of an obstacle at a time [s], in its own frame [m].
std::shared_ptr<const TriangleMesh> obstacle_surface(const Simulation& simulation, const Stage& stage,
                                                     std::size_t obstacle, double time);

/// A mesh in another place.
TriangleMesh moved(const TriangleMesh& mesh, const Pose& pose);

/// The rectangle that a scene's light is at a time [s].
AreaLight area_light(const LightDescription& light, double time = 0);

}  // namespace umax
