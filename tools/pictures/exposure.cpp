#include "tools/pictures/exposure.h"

#include <algorithm>

namespace umax {

Exposure endless_exposure(const RenderDescription& render, int frame) {
  const bool blurs = render.engine == RenderEngine::embree && render.heatmap == Heatmap::none;
  if (!blurs || !(render.shutter > 0)) return {double(frame), double(frame)};
  return {frame - render.shutter_position * render.shutter, frame + (1 - render.shutter_position) * render.shutter};
}

Exposure exposure_of(const RenderDescription& render, int frame, int last_frame) {
  Exposure exposure = endless_exposure(render, frame);
  exposure.opens = std::clamp(exposure.opens, 1.0, double(std::max(1, frame)));
  exposure.closes = std::clamp(exposure.closes, double(frame), double(std::max(last_frame, frame)));
  return exposure;
}

int filter_reach(const RenderDescription& render) {
  const bool looks = render.engine == RenderEngine::embree && render.denoise == NoiseFilter::temporal;
  return looks && !render.preview && !render.transparent ? 2 : 0;
}

FrameWindow frames_for(const RenderDescription& render, int frame, int last_frame) {
  const int reach = filter_reach(render);
  return {std::max(frame - reach, std::min(frame, 1)), std::min(frame + reach, std::max(last_frame, frame))};
}

StateWindow states_of_shot(const RenderDescription& render, int frame, int last_frame) {
  const Exposure exposure = exposure_of(render, frame, last_frame);
  StateWindow window{exposure.first_state(), exposure.last_state()};
  if (!render.has_layer(PictureLayer::vector)) return window;
  window.first = std::min(window.first, std::max(frame - 1, 1));
  window.last = std::max(window.last, std::min(frame + 1, std::max(last_frame, frame)));
  return window;
}

StateWindow states_for(const RenderDescription& render, int frame, int last_frame) {
  const FrameWindow frames = frames_for(render, frame, last_frame);
  RenderDescription without_motion = render;
  without_motion.layers.clear();
  StateWindow window = states_of_shot(render, frame, last_frame);
  window.first = std::min(window.first, states_of_shot(without_motion, frames.first, last_frame).first);
  window.last = std::max(window.last, states_of_shot(without_motion, frames.last, last_frame).last);
  return window;
}

int last_frame_with(const RenderDescription& render, int count, int last_frame) {
  int frame = std::min(count, last_frame);
  while (frame > 0 && states_for(render, frame, last_frame).last > count) --frame;
  return frame;
}

}  // namespace umax
