// What the middles of pixels show, and where edges cross pixels: found by one ray each, before any path is traced.
#pragma once

#include <vector>

#include "render/trace/ray_scene.h"

namespace umax {

struct FirstHitOptions {
  int width = 0, height = 0;  // [px] of the picture
  float time = 0;             // while the shutter is open: 0 as it opens, 1 as it closes
  int step = 1;               // [px] from one pixel that is looked at to the next, right and down, from step / 2 on
};
/// Through the middle of the lens, row by row. The values do not depend on the number of threads.
std::vector<Hit> find_first_hits(const RayScene& rays, const RenderScene& scene, const FirstHitOptions& options);

/// Of all pixels, at the scene's moment.
std::vector<Hit> find_first_hits(const RayScene& rays, const RenderScene& scene, int width, int height);

/// Whether two rays have met different objects, or one where its colour or direction is another.
bool differ(const RayScene& rays, const Hit& a, const Hit& b);

/// 1 for pixels that show something else than a pixel beside them: another object, colour or direction of the surface, or
/// what lies behind it; else 0.
std::vector<char> find_edges(const RayScene& rays, const std::vector<Hit>& hits, int width, int height);

/// Of pixels that edges sweep over.
inline constexpr char swept_edge = 2;

/// The same at the scene's moment, and swept_edge for pixels that edges sweep over while the shutter is open. hits: at the moment.
/// The values do not depend on the number of threads.
std::vector<char> find_swept_edges(const RayScene& rays, const RenderScene& scene, const std::vector<Hit>& hits,
                                   int width, int height);

}  // namespace umax
