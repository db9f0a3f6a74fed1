// A scene is set up, stepped and drawn by the libraries of an installed umax.
#include <cstdio>

#include "core/base/error.h"
#include "render/trace/path_trace.h"
#include "scenes/scene_file.h"
#include "tools/setup/stepping.h"

int main(int argc, char** argv) {
  try {
    const umax::Simulation simulation = umax::set_up(umax::load_scene(argc > 1 ? argv[1] : "beam"));
    umax::Stepping stepping = umax::begin_stepping(simulation);
    umax::State state = umax::rest_state(simulation.model);
    for (int i = 0; i < 3; ++i) umax::advance(stepping, {}, state);
    std::printf("%.17g\n", state.positions.col(1).minCoeff());
    umax::RenderScene scene;
    const umax::Image image = umax::path_trace(scene, {.width = 8, .height = 8, .samples = 1}).color;
    return image.width == 8 ? 0 : 1;
  } catch (const umax::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
