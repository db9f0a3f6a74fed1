// What the path tracer makes of a shot: the colour that is shown, and the layers that a compositor wants.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/image/image_io.h"
#include "render/trace/clip_frame.h"
#include "render/trace/surface_data.h"
#include "render/trace/triangle_clusters.h"
#include "scenes/scene.h"

namespace umax {

constexpr int preview_paths = 2;  // a pixel of a preview, at most

struct TracedPicture {
  std::vector<Layer> layers;  // the colour first, with alpha (premultiplied) where it has one
  ExrHeader header;
};

/// What a shot's paths have brought, before anything is filtered.
struct TracedShot {
  RenderScene shot;
  TracedImage image;
  std::vector<std::string> object_names, material_names;  // of the image's mattes
  std::optional<SurfaceData> data;                        // where the scene wants its layers
  std::optional<ClipFrame> frame;                         // what the filters of other frames take of it
  bool is_cut_out = false;
};

/// frame: its number, for a filter that looks at other frames; none: of a picture by itself. Unfinished when a signal
/// asked to stop meanwhile. clusters: kept from shot to shot, or none.
TracedShot trace_shot(RenderScene shot, const RenderDescription& render, std::optional<int> frame,
                      ClusterCache* clusters = nullptr);

/// The colour of a frame, the window's number `centre`, from the light that all of the window show.
Image filter_gathered(const TracedImage& image, const std::vector<const ClipFrame*>& window, std::size_t centre);

/// Filters and sorts into layers; the shot's image is used up. window: the frames that the filter looks at, the shot's own
/// at `centre`; empty: the filter looks at the picture alone. No layers when a signal asked to stop meanwhile.
TracedPicture finish_picture(TracedShot& traced, const RenderDescription& render,
                             const std::vector<const ClipFrame*>& window, std::size_t centre);

}  // namespace umax
