// What the middles of pixels show, and where edges cross pixels: found by one ray each, before any path is traced.
#pragma once

#include <vector>

#include "render/trace/ray_scene.h"

namespace umax {

/// At the scene's moment, through the middle of the lens, row by row. The values do not depend on the number of threads.
std::vector<Hit> find_first_hits(const RayScene& rays, const RenderScene& scene, int width, int height);

/// 1 for pixels that show something else than a pixel beside them: another object, colour or direction of the surface, or
/// what lies behind it; else 0.
std::vector<char> find_edges(const RayScene& rays, const std::vector<Hit>& hits, int width, int height);

}  // namespace umax
