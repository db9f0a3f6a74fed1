#include "tools/run/picture_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "tools/pictures/exposure.h"
#include "tools/pictures/traced_picture.h"
#include "tools/run/job_estimate.h"
#include "tools/system/machine_memory.h"
#include "tools/system/progress.h"

namespace umax {
namespace {

// Measured on an Intel Xeon beside other work: user time and peak of `umax render --threads 1` of the figure (232,000
// triangles), 1 and 2 pictures, set-up left out:
//   embree   640x360: 16 paths 0.72 s, 64 paths 2.3 s, filtered 0.35 s more; 207 MB, filtered 343. 1280x720, 16 paths: 2.3 s;
//            283 MB, filtered 733. Bodies that fill the picture take up to twice the time a path.
//   osmesa   640x360: 4 samples 0.53 s, 16 samples 1.35 s; 326 and 408 MB. 1280x720, 4 samples 1.05 s; 553 MB
//   ffmpeg   40 pictures: 640x360 0.7 s, 112 MB; 1280x720 1.6 s, 244 MB
constexpr double process_bytes = 120e6;  // with no body
constexpr double bytes_per_triangle = 300;
constexpr double bytes_per_pixel = 110, window_bytes_per_pixel = 150;  // the latter of each frame that the filter keeps
constexpr double path_seconds = 2e-7;
constexpr double filter_seconds = 3.5e-7;  // a pixel of each frame that it looks at
constexpr double triangle_seconds = 8e-7;  // placing it, and its share of the hierarchy
constexpr double raster_bytes = 100e6, raster_bytes_per_pixel = 330;
constexpr double raster_seconds_per_pixel = 1e-6;
constexpr double raster_seconds_per_triangle = 4.7e-6;  // into all shadow maps
constexpr double whole_raster_samples = 16;             // from which on there are all shadow maps
constexpr double encoder_bytes = 70e6, encode_bytes_per_pixel = 190;
constexpr double encode_seconds_per_pixel = 5e-8;

}  // namespace

PictureJob picture_job(const Simulation& simulation, const std::vector<int>& drawn, int clip_frames, int threads) {
  const RenderDescription& render = simulation.scene.render;
  PictureJob job{.pixels = double(render.width) * render.height,
                 .samples = double(render.preview ? std::min(render.samples, preview_paths) : render.samples),
                 .pictures = int(drawn.size()),
                 .window = 2 * filter_reach(render) + 1,
                 .clip_frames = clip_frames,
                 .threads = threads,
                 .is_rasterised = render.engine == RenderEngine::osmesa,
                 .is_filtered = render.denoise != NoiseFilter::none};
  for (const BodySetup& body : simulation.bodies) job.triangles += double(body.shape.mesh.num_triangles());
  for (const ObstacleSetup& obstacle : simulation.obstacles)
    if (obstacle.mesh) job.triangles += double(obstacle.mesh->num_triangles());
  std::set<int> shots;
  for (const int frame : drawn) {
    const FrameWindow window = frames_for(render, frame, simulation.last_frame());
    for (int shot = window.first; shot <= window.last; ++shot) shots.insert(shot);
    const Exposure exposure = exposure_of(render, frame, simulation.last_frame());
    job.states = std::max(job.states, double(exposure.last_state() - exposure.first_state() + 1));
  }
  job.shots = int(shots.size());
  return job;
}

PictureEstimate estimate(const PictureJob& job) {
  PictureEstimate cost;
  cost.memory = process_bytes + bytes_per_triangle * job.triangles * (1 + job.states) / 2;
  if (job.is_rasterised)
    cost.memory += raster_bytes + raster_bytes_per_pixel * job.pixels;
  else
    cost.memory += job.pixels * (bytes_per_pixel + (job.window > 1 ? window_bytes_per_pixel * job.window : 0));
  double shot = triangle_seconds * job.triangles * job.states, finish = 0;
  if (job.is_rasterised) {
    const double share = std::min(1.0, job.samples / whole_raster_samples);
    shot += share * raster_seconds_per_triangle * job.triangles + raster_seconds_per_pixel * job.pixels;
  } else {
    shot += path_seconds * job.samples * job.pixels;
    if (job.is_filtered) finish = filter_seconds * job.pixels * job.window;
  }
  cost.render_seconds = (shot * job.shots + finish * job.pictures) / job.threads;
  cost.picture_seconds = job.pictures > 0 ? cost.render_seconds / job.pictures : 0;
  if (job.clip_frames > 0) {
    cost.encode_seconds = encode_seconds_per_pixel * job.pixels * job.clip_frames / job.threads;
    cost.encode_memory = encoder_bytes + encode_bytes_per_pixel * job.pixels;
  }
  return cost;
}

std::string announce(const PictureJob& job) {
  const PictureEstimate cost = estimate(job);
  const double memory = std::max(job.pictures > 0 ? cost.memory : 0, cost.encode_memory);
  if (!is_worth_saying(memory, cost.render_seconds + cost.encode_seconds)) return {};
  const std::string clip =
      fmt::format("{} and {} for the clip", format_duration(cost.encode_seconds), format_memory(cost.encode_memory));
  if (job.pictures == 0) return "about " + clip;
  const std::string text =
      fmt::format("pictures: about {} of memory and {} ({} of about {} s by {} on {} threads)",
                  format_memory(cost.memory), format_duration(cost.render_seconds), job.pictures,
                  seconds_text(cost.picture_seconds), job.is_rasterised ? "osmesa" : "embree", job.threads);
  return job.clip_frames > 0 ? text + ", and " + clip : text;
}

}  // namespace umax
