// Figures of the demo's clip as pictures: what it takes, how far it is from pictures of very many samples, how much it
// flickers, and what the noise filter alone takes.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "render/image/flip.h"
#include "render/image/image_io.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/benchmarks/measured_command.h"
#include "tools/pictures/traced_picture.h"
#include "tools/run/render_frames.h"
#include "tools/run/run_record.h"
#include "tools/system/scratch_folder.h"
#include "tools/system/seconds_since.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

// pairs of frames that follow each other: in flight, landing, tipping over, rolling, at rest
const std::vector<int> first_of_pairs{15, 45, 75, 105, 135};
constexpr const char* compared_frames = "15-16,45-46,75-76,105-106,135-136";
constexpr int reference_samples = 1024;

// of the scene's pictures and of the states that they show
std::string reference_name(const fs::path& run) {
  Scene scene = load_scene((run / "scene.toml").string(), {});
  scene.render.samples = reference_samples;
  scene.render.denoise = NoiseFilter::none;
  std::string text = resolved_toml(scene);
  for (const int first : first_of_pairs)
    for (const int frame : {first, first + 1}) text += sha256_hex(read_file(state_path(run, frame)));
  return "umax-references-" + sha256_hex(text).substr(0, 16);
}

// pictures of very many samples: they take minutes, so that they are kept until the scene changes
fs::path references_of(const fs::path& run) {
  const fs::path kept = fs::temp_directory_path() / reference_name(run);
  measure_command({program(), "render", run, "-o", kept, "--frames", compared_frames, "--samples",
                   std::to_string(reference_samples), "--seed", "7", "--set", "render.denoise=none", "--resume",
                   "--quiet"});
  return kept;
}

double mean_flip(const fs::path& references, const fs::path& pictures) {
  double sum = 0;
  for (const int first : first_of_pairs)
    for (const int frame : {first, first + 1})
      sum += flip(read_png8(picture_path(references, frame)), read_png8(picture_path(pictures, frame))).mean;
  return sum / double(2 * first_of_pairs.size());
}

// the demo's frames as a filter takes them
class DemoFrames {
 public:
  explicit DemoFrames(const fs::path& run, int samples = 0)
      : simulation_(set_up(scene_with(run, samples))), pictures_(pictures_of_run(simulation_, run, first_of_pairs)) {}

  const RenderDescription& render() const { return simulation_.scene.render; }
  TracedShot trace(int frame) const { return trace_shot(pictures_.list.beside(frame), render(), frame); }

 private:
  static Scene scene_with(const fs::path& run, int samples) {
    Scene scene = load_scene((run / "scene.toml").string(), {});
    if (samples > 0) scene.render.samples = samples;
    return scene;
  }
  Simulation simulation_;
  RunPictures pictures_;
};

// which places of the frame before the pixels of a frame show; none: hidden or outside
using Places = std::vector<std::optional<Reprojection::Place>>;

Places places_before(const ClipFrame& before, const ClipFrame& now) {
  const Reprojection reprojection(now, before);
  Places places;
  for (int y = 0; y < now.height; ++y)
    for (int x = 0; x < now.width; ++x) {
      const Reprojection::Place place = reprojection.place(x, y);
      const int column = int(std::floor(place.x)), row = int(std::floor(place.y));
      std::optional<Reprojection::Place>& found = places.emplace_back();
      if (!place.has_place || column < 1 || row < 1 || column + 1 >= now.width || row + 1 >= now.height) continue;
      const SeenPoint &here = now.point(x, y), &there = before.point(column, row);
      if (here.object == there.object && std::abs(there.distance - place.distance) <= 0.02f * place.distance)
        found = place;
    }
  return places;
}

double value_at(const Image8& picture, const Reprojection::Place& place, int channel) {
  const double x = double(place.x) - 0.5, y = double(place.y) - 0.5;
  const int column = int(std::floor(x)), row = int(std::floor(y));
  const auto at = [&](int c, int r) {
    return double(picture.pixel(std::min(c, picture.width - 1), std::min(r, picture.height - 1))[channel]);
  };
  const double u = x - column, v = y - row;
  return (1 - v) * ((1 - u) * at(column, row) + u * at(column + 1, row)) +
         v * ((1 - u) * at(column, row + 1) + u * at(column + 1, row + 1));
}

// mean absolute difference of two pictures after motion compensation, in steps of 1/255
double difference(const Image8& before, const Image8& now, const Places& places) {
  double sum = 0;
  long long count = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i]) {
      for (int c = 0; c < 3; ++c)
        sum += std::abs(value_at(before, *places[i], c) - double(now.values[3 * i + std::size_t(c)]));
      count += 3;
    }
  return sum / double(count);
}

double flicker(const fs::path& pictures, const std::vector<Places>& places) {
  double sum = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    sum += difference(read_png8(picture_path(pictures, first_of_pairs[i])),
                      read_png8(picture_path(pictures, first_of_pairs[i] + 1)), places[i]);
  return sum / double(places.size());
}

std::vector<Places> places_of_pairs(const fs::path& run) {
  const DemoFrames frames(run, 1);
  std::vector<Places> places;
  for (const int first : first_of_pairs)
    places.push_back(places_before(*frames.trace(first).frame, *frames.trace(first + 1).frame));
  return places;
}

// seconds of what is done for the filter in every frame
double filter_seconds(const fs::path& run) {
  const DemoFrames frames(run);
  std::vector<TracedShot> traced;
  std::vector<const ClipFrame*> window;
  for (int frame = 43; frame <= 47; ++frame) traced.push_back(frames.trace(frame));
  for (const TracedShot& shot : traced) window.push_back(&*shot.frame);
  const RenderScene& shot = traced[2].shot;
  const RayScene rays(shot);
  const RenderDescription& render = frames.render();
  const TracedImage image =
      path_trace(rays, shot, {.width = render.width, .height = render.height, .samples = render.samples});
  double least = 1e9;
  for (int turn = 0; turn < 5; ++turn) {
    const auto start = std::chrono::steady_clock::now();
    const ClipFrame again = make_clip_frame(find_first_hits(rays, shot, render.width, render.height), shot, image);
    const Image filtered = filter_gathered(image, window, 2);
    least = std::min(least, seconds_since(start));
  }
  return least;
}

BenchRows clip() {
  const ScratchFolder scratch;
  const fs::path run = scratch.path() / "demo";
  // the ground as it was when the figures were asked for: it ends far away
  const Measurement outcome =
      measure_command({program(), "run", "figure", "--set", "obstacle.ground.fade=1e6", "-o", run, "--quiet"});
  const auto record = read_run_record(run / "run.json");
  const fs::path references = references_of(run);
  const std::vector<Places> places = places_of_pairs(run);
  const double ours = flicker(run, places), converged = flicker(references, places);
  return {at_most("demo's clip, 640x360, 150 frames, encoded", outcome.seconds, 50, "s",
                  fmt::format("{:.0f} s of processors, {:.1f} s of pictures", outcome.cpu_seconds,
                              record ? record->render_seconds : 0)),
          at_most("its frames against 1024 samples: mean FLIP of 10", mean_flip(references, run), 0.015, ""),
          at_most("its flicker over that of 1024 samples, 5 pairs of frames", ours / converged, 1.3, "x",
                  fmt::format("{:.3f} against {:.3f} of 255", ours, converged)),
          at_most("noise filter alone, a frame of 640x360", filter_seconds(run), 0.08, "s")};
}

BenchRows large_clip() {
  const ScratchFolder scratch;
  const Measurement outcome = measure_command({program(), "run", "figure", "--set", "obstacle.ground.fade=1e6",
                                               "--size", "1280x720", "-o", scratch.path() / "demo", "--quiet"});
  return {at_most("demo's clip, 1280x720, 150 frames, encoded", outcome.seconds, 170, "s",
                  fmt::format("{:.0f} s of processors", outcome.cpu_seconds))};
}

}  // namespace

std::vector<Benchmark> clip_benchmarks() {
  return {{"clip", true, false, clip}, {"clip-720", true, false, large_clip}};
}

}  // namespace umax
