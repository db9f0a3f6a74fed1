// Pictures to files: the engine that the scene asks for, tone map, PNG and EXR.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "render/image/image.h"
#include "render/scene/render_scene.h"
#include "tools/pictures/exposure.h"

namespace umax {

struct TracedPicture;

/// What is drawn as which picture.
struct PictureList {
  std::vector<int> frames;                       // numbers of the pictures, increasing
  std::function<RenderScene(int frame)> shot;    // of one that is drawn; throws Error when it cannot be had
  std::function<RenderScene(int frame)> beside;  // of one that the filter of another looks at
  std::function<FrameWindow(int frame)> window;  // the frames that the filter looks at
};

struct DrawnPicture {
  Image linear;  // scene-linear RGB, of a transparent picture RGBA, straight
  Image8 shown;  // as the PNG has it
};

/// Throws Error (unavailable) when the library of the scene's engine is not there: for what would draw only after long work.
void require_engine(const RenderDescription& render);

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
  /// The same of a frame of the list. What frames that follow will look at is kept until then.
  bool paint(const PictureList& list, int frame, const std::filesystem::path& png);

  /// The pictures that paint() would put into files; none when a signal asks us to stop meanwhile.
  std::optional<DrawnPicture> draw(const RenderScene& shot);
  std::optional<DrawnPicture> draw(const PictureList& list, int frame);

 private:
  struct Engine;
  /// What becomes of a picture once it is drawn.
  using Use = std::function<void(TracedPicture&, const RenderScene& shot)>;
  bool make(const RenderScene& shot, const Use& use);
  bool make(const PictureList& list, int frame, const Use& use);
  void write(TracedPicture& picture, const RenderScene& shot, const std::filesystem::path& png) const;
  RenderDescription render_;
  std::unique_ptr<Engine> engine_;
};

}  // namespace umax
