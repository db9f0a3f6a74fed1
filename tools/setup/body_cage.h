// A body is placed and gets its cage: hexes around its shape, or those of a file.
#pragma once

#include <vector>

#include "embedding/cage/voxelize.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

/// The cage options that a scene's cage key means; not for cage.mesh.
CageOptions cage_options(const CageDescription& cage);

/// Places the scene's next body, the one behind `caged`, and gives it a cage with its embedding: that of an earlier body which
/// differs in its place alone, the very one that the library has from an earlier scene, or a new one. obstacles: what
/// drop_height is measured from. Throws Error that names the body.
BodySetup cage_body(const Scene& scene, const std::vector<BodySetup>& caged, const std::vector<Obstacle>& obstacles,
                    ShapeLibrary& library);

}  // namespace umax
