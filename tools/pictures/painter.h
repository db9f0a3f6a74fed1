// Pictures to files: the engine that the scene asks for, tone map, PNG and EXR.
#pragma once

#include <filesystem>
#include <memory>

#include "render/scene/render_scene.h"
#include "scenes/scene.h"

namespace umax {

/// Draws one picture after the other; keeps what the engine can use again.
class Painter {
 public:
  /// Throws Error (unavailable) when the engine cannot be had.
  Painter(const RenderDescription& render, int threads);
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  /// Draws the shot and puts it at `png` (and beside it as .exr when the scene asks for it), whole or not at all.
  /// False, and no file, when a signal asks us to stop meanwhile.
  bool paint(const RenderScene& shot, const std::filesystem::path& png);

 private:
  struct Engine;
  RenderDescription render_;
  std::unique_ptr<Engine> engine_;
};

}  // namespace umax
