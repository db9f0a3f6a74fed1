// Many light paths side by side: what tracer and scene share, and the paths' way from the camera to their ends.
#pragma once

#include <optional>
#include <vector>

#include "render/scene/camera.h"
#include "render/scene/light.h"
#include "render/scene/render_scene.h"
#include "render/scene/sampling.h"
#include "render/trace/bsdf.h"
#include "render/trace/matter.h"
#include "render/trace/ray_scene.h"

namespace umax {

/// Everything that stays the same for a whole picture.
struct PathTracer {
  const RayScene& rays;
  std::vector<BsdfLook> looks;  // one per object
  std::vector<Matter> matters;  // likewise
  bool has_matter = false;      // whether light enters any object
  bool shows_backdrop = true;   // through clear matter, too
  RectangleLights lights;
  SkyLight sky;
  std::optional<Vector3f> backdrop;
  std::vector<std::optional<Fade>> fades;  // of each object; none: nothing fades
  std::vector<CameraView> cameras;  // at even times from the shutter's opening to its closing; one: it stands still
  bool has_shutter = false;         // whether anything moves
  bool keeps_parts = false;         // whether it is asked which surfaces paths met first
  SampleSequence sequence;
  int first_sample = 0;  // of the picture, in the sequence
  const PixelFilter& filter;
  int bounces;
};

/// One path to be traced: a pixel of the whole picture and the number of its sample. Samples of one stream are spread
/// well together; streams know nothing of each other.
struct PathStart {
  int x = 0, y = 0, sample = 0, stream = 0;
};

/// What one path brings back.
struct PathResult {
  Vector3f radiance{0, 0, 0}, albedo{1, 1, 1}, normal{0, 0, 0};  // the last two of the first surface
  float depth = 0;                                               // [m] 0: it met nothing
};

/// What a path met first.
struct FirstPart {
  unsigned object = Hit::nothing, triangle = 0;
};

/// Paths that are traced together, step by step, so that shading is vector code. A path's result does not depend on the
/// others. One per thread: it owns its buffers.
class PathWave {
 public:
  static constexpr int max_paths = rows::capacity;

  explicit PathWave(const PathTracer& tracer);
  ~PathWave();

  /// Traces up to max_paths paths. recording: receives the rays, or null.
  const PathResult* trace(const std::vector<PathStart>& starts, std::vector<RecordedRay>* recording);
  /// Of the paths that trace() has traced, where the tracer keeps them.
  const FirstPart* first_parts() const;

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace umax
