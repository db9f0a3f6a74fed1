#include "tools/python/picture_view.h"

#include "tools/pictures/shot.h"

namespace umax {

RenderScene shot_of_state(const Simulation& simulation, const State& start, const State& state) {
  const RenderDescription& render = simulation.scene.render;
  Box box = box_of(simulation, start.positions);
  box.extend(box_of(simulation, state.positions));
  HeatRange range;
  extend(range, simulation, state);
  const Camera camera = frame_camera(simulation.scene.camera, box, double(render.width) / render.height, state.time);
  return make_shot(simulation, make_stage(simulation, box, range), state, camera);
}

}  // namespace umax
