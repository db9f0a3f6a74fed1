// What the path tracer makes of a shot: the colour that is shown, and the layers that a compositor wants.
#pragma once

#include <vector>

#include "render/image/image_io.h"
#include "render/scene/render_scene.h"
#include "scenes/scene.h"

namespace umax {

struct TracedPicture {
  std::vector<Layer> layers;  // the colour first, with alpha (premultiplied) where it has one
  ExrHeader header;
};

/// No layers when a signal asked to stop meanwhile.
TracedPicture trace_picture(const RenderScene& shot, const RenderDescription& render);

}  // namespace umax
