// While which time a picture's shutter is open, and so which states it needs.
#pragma once

#include <cmath>

#include "scenes/scene.h"

namespace umax {

struct Exposure {
  double opens = 1, closes = 1;  // [frames] the frame's own number lies in between
  bool is_open() const { return closes > opens; }
  int first_state() const { return int(std::floor(opens)); }
  int last_state() const { return int(std::ceil(closes)); }
  /// Time of a place in the clip [frames] as renderers take it: 0 when the shutter opens, 1 when it closes.
  float share(double frame) const { return float((frame - opens) / (closes - opens)); }
  bool operator==(const Exposure&) const = default;
};

/// Of a frame of a clip of `last_frame` frames, cut off at the clip's ends. Pictures that do not blur (heat maps, those of
/// the rasteriser, without a shutter) need their own state alone.
Exposure exposure_of(const RenderDescription& render, int frame, int last_frame);

/// The same without a first and a last frame: of a circle.
Exposure endless_exposure(const RenderDescription& render, int frame);

/// Frames before and after one that its noise filter looks at; 0: none.
int filter_reach(const RenderDescription& render);

/// The frames that a picture's noise filter looks at, within the clip.
struct FrameWindow {
  int first = 1, last = 1;
};
FrameWindow frames_for(const RenderDescription& render, int frame, int last_frame);

/// The states that a frame's shot needs: those while its shutter is open and, where it has motion vectors, the frame's
/// neighbours, within the clip.
struct StateWindow {
  int first = 1, last = 1;
  bool operator==(const StateWindow&) const = default;
};
StateWindow states_of_shot(const RenderDescription& render, int frame, int last_frame);

/// The states that its picture needs: of the shots of all frames that the filter looks at.
StateWindow states_for(const RenderDescription& render, int frame, int last_frame);

/// The last frame of a clip of `last_frame` frames that `count` states are enough for; 0: none.
int last_frame_with(const RenderDescription& render, int count, int last_frame);

}  // namespace umax
