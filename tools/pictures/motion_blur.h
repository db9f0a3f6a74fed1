// What moves while a picture's shutter is open, and from frame to frame: bodies between their states, obstacles along
// their tracks, the camera.
#pragma once

#include <functional>
#include <vector>

#include "tools/pictures/exposure.h"
#include "tools/pictures/shot.h"

namespace umax {

/// Gives bodies and obstacles of a shot their motion. states: those of the exposure's first_state() to last_state();
/// frame: the shot's own. Bodies go straight from state to state, obstacles as their tracks say. Does nothing when the
/// shutter is not open.
void add_motion(const Simulation& simulation, const Stage& stage, const std::vector<State>& states,
                const Exposure& exposure, int frame, RenderScene& shot);

/// Gives bodies and obstacles of a shot their places one frame before and after, where the scene wants motion vectors.
/// states: those of the window. At the clip's two ends what is missing stays where it is.
void add_neighbours(const Simulation& simulation, const Stage& stage, const std::vector<State>& states,
                    const StateWindow& window, int frame, RenderScene& shot);

/// Gives a shot the camera's way. camera_at: at a place of the clip [frames].
void add_camera_motion(const Exposure& exposure, const std::function<Camera(double frame)>& camera_at,
                       RenderScene& shot);

}  // namespace umax
