#include "tools/run/render_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "scenes/resolved_scene.h"
#include "tools/pictures/motion_blur.h"
#include "tools/run/clip.h"
#include "tools/run/run_motion.h"

namespace umax {
namespace {

double aspect_of(const RenderDescription& render) {
  return double(render.width) / render.height;
}

/// Of the scene as it is drawn: how many frames there are does not matter to a picture by itself.
PictureRecord picture_record(const Simulation& simulation, const std::string& view) {
  Scene scene = simulation.scene;
  scene.clip.frames = 1;
  PictureRecord record{.settings = resolved_toml(scene), .digest = {}, .clip_frames = simulation.last_frame()};
  record.digest = sha256_hex(record.settings + simulation.digest + view);
  return record;
}

std::string camera_text(const Camera& camera) {
  std::string text;
  for (const Vector3f& vector : {camera.position, camera.target})
    text += fmt::format("{} {} {} ", vector.x(), vector.y(), vector.z());
  return text;
}

/// Of a camera that another program has animated.
std::string file_text(const CameraDescription& camera) {
  return camera.motion ? "camera " + sha256_hex(read_file(camera.file)) + " " : "";
}

/// Of a heat map's bar, whose range depends on the motion.
std::string legend_text(const Stage& stage) {
  if (!stage.legend) return {};
  const Legend& legend = *stage.legend;
  return fmt::format("heat to {} {} {} ", legend.high, legend.ends_at_limit, legend.slack);
}

void require_exposed_states(const Simulation& simulation, const std::filesystem::path& run,
                            const std::vector<int>& frames) {
  for (const int frame : frames) {
    const StateWindow window = states_for(simulation.scene.render, frame, simulation.last_frame());
    for (int needed = window.first; needed <= window.last; ++needed) {
      if (std::error_code error; std::filesystem::exists(state_path(run, needed), error)) continue;
      throw Error(Fault::not_found,
                  {.where = state_path(run, needed).string(),
                   .what = needed == frame ? "there is no state of this frame"
                                           : fmt::format("frame {} needs this state for what moves", frame),
                   .remedy = "simulate it first, or name other frames with --frames"});
    }
  }
}

std::vector<State> read_states(const Simulation& simulation, const std::filesystem::path& run,
                               const StateWindow& window) {
  std::vector<State> states;
  for (int frame = window.first; frame <= window.last; ++frame)
    states.push_back(read_state(state_path(run, frame), simulation.model, simulation.digest));
  return states;
}

/// Whether pictures show shadows alone of anything: each is then filtered by itself.
bool has_catchers(const Scene& scene) {
  return std::any_of(scene.obstacles.begin(), scene.obstacles.end(),
                     [](const ObstacleDescription& obstacle) { return obstacle.visible && obstacle.shadow_catcher; });
}

/// What shots of a run are made of.
struct RunView {
  const Simulation& simulation;
  std::filesystem::path run;
  Box box;      // around the motion
  ViewFit fit;  // of it
  std::shared_ptr<const Stage> stage;

  Camera camera_at(double frame) const {
    const Scene& scene = simulation.scene;
    const double time = (frame - 1) / scene.clip.fps;
    if (is_framed(scene.camera)) return frame_camera(scene.camera, fit, time);
    return frame_camera(scene.camera, box, aspect_of(scene.render), time);
  }
};

/// wanted: as the scene has it, or without layers that need more states than the shot.
RenderScene shot_of(const RunView& view, int frame, const RenderDescription& wanted) {
  const Simulation& simulation = view.simulation;
  const Exposure exposure = exposure_of(wanted, frame, simulation.last_frame());
  const StateWindow window = states_of_shot(wanted, frame, simulation.last_frame());
  const std::vector<State> states = read_states(simulation, view.run, window);
  const auto state_of = [&](int number) { return states.begin() + (number - window.first); };
  RenderScene shot = make_shot(simulation, *view.stage, *state_of(frame), view.camera_at(frame));
  add_motion(simulation, *view.stage, {state_of(exposure.first_state()), state_of(exposure.last_state()) + 1}, exposure,
             frame, shot);
  if (wanted.has_layer(PictureLayer::vector)) add_neighbours(simulation, *view.stage, states, window, frame, shot);
  if (!simulation.scene.camera.moves()) return shot;
  add_camera_motion(exposure, [&](double place) { return view.camera_at(place); }, shot);
  if (window.first < frame) shot.previous_camera = view.camera_at(frame - 1);
  if (window.last > frame) shot.next_camera = view.camera_at(frame + 1);
  return shot;
}

}  // namespace

RunPictures pictures_of_run(const Simulation& simulation, const std::filesystem::path& run,
                            const std::vector<int>& frames) {
  require_exposed_states(simulation, run, frames);
  const RunMotion motion = motion_of_run(simulation, run);
  const RenderDescription& render = simulation.scene.render;
  const Camera camera = is_framed(simulation.scene.camera)
                            ? frame_camera(simulation.scene.camera, motion.fit)
                            : frame_camera(simulation.scene.camera, motion.box, aspect_of(render));
  auto stage = std::make_shared<const Stage>(make_stage(simulation, motion.box, motion.heat));
  RunPictures pictures;
  pictures.record = picture_record(
      simulation, "run " + camera_text(camera) + legend_text(*stage) + file_text(simulation.scene.camera));
  if (motion.departure > 0)
    pictures.notes.push_back(
        fmt::format("render.surface is smooth: at most {:.3g} m from where contact feels bodies", motion.departure));
  pictures.list.frames = frames;
  const RunView view{.simulation = simulation, .run = run, .box = motion.box, .fit = motion.fit, .stage = stage};
  pictures.list.shot = [view](int frame) { return shot_of(view, frame, view.simulation.scene.render); };
  pictures.list.beside = [view, without_layers = render](int frame) mutable {
    without_layers.layers.clear();
    return shot_of(view, frame, without_layers);
  };
  pictures.list.window = [&simulation](int frame) {
    const Scene& scene = simulation.scene;
    return has_catchers(scene) ? FrameWindow{frame, frame} : frames_for(scene.render, frame, simulation.last_frame());
  };
  return pictures;
}

Camera camera_of_run(const Simulation& simulation, const std::filesystem::path& run) {
  const CameraDescription& camera = simulation.scene.camera;
  const bool is_given = camera.motion || (camera.position && camera.target);
  const RunMotion motion = is_given ? RunMotion() : motion_of_run(simulation, run);
  if (is_framed(camera)) return frame_camera(camera, motion.fit);
  return frame_camera(camera, motion.box, aspect_of(simulation.scene.render));
}

namespace {

/// Of all bodies, #P x 3 [m].
Points surface_points(const Simulation& simulation, const State& state) {
  Points all;
  for (const BodySetup& body : simulation.bodies) {
    const Points surface = surface_points(body, state.positions);
    all.conservativeResize(all.rows() + surface.rows(), 3);
    all.bottomRows(surface.rows()) = surface;
  }
  return all;
}

}  // namespace

RunPictures turntable_of(const Simulation& simulation, const State& state, const std::vector<int>& frames) {
  const Box box = box_of(simulation, state.positions);
  HeatRange range;
  extend(range, simulation, state);
  auto stage = std::make_shared<const Stage>(make_stage(simulation, box, range));
  RunPictures pictures;
  pictures.record = picture_record(
      simulation, fmt::format("turntable {} of {}", state.step, simulation.last_frame()) + legend_text(*stage));
  pictures.list.frames = frames;
  const TurntableFit fit =
      turntable_fit(simulation.scene.camera, surface_points(simulation, state), aspect_of(simulation.scene.render));
  pictures.list.shot = [&simulation, state, box, fit, stage](int frame) {
    const auto camera_at = [&](double place) {
      const double turns = (place - 1) / simulation.last_frame();
      if (is_framed(simulation.scene.camera))
        return turntable_camera(simulation.scene.camera, fit, turns - std::floor(turns));
      return turntable_camera(simulation.scene.camera, box, aspect_of(simulation.scene.render),
                              turns - std::floor(turns));
    };
    RenderScene shot = make_shot(simulation, *stage, state, camera_at(frame));
    add_camera_motion(endless_exposure(simulation.scene.render, frame), camera_at, shot);
    shot.previous_camera = camera_at(frame - 1);
    shot.next_camera = camera_at(frame + 1);
    shot.moment = float(simulation.scene.render.shutter_position);
    return shot;
  };
  // the circle has no end
  pictures.list.beside = pictures.list.shot;
  const int reach = has_catchers(simulation.scene) ? 0 : filter_reach(simulation.scene.render);
  pictures.list.window = [reach](int frame) { return FrameWindow{frame - reach, frame + reach}; };
  return pictures;
}

void encode_pictures(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene, Progress& progress) {
  std::vector<std::filesystem::path> pictures;
  for (const int frame : frames) pictures.push_back(folder.picture(frame));
  encode_clip(folder.clip(), pictures,
              {.fps = scene.clip.fps,
               .width = scene.render.width,
               .height = scene.render.height,
               .transparent = scene.render.transparent});
  progress.note(fmt::format("clip: {} ({} frames)", folder.clip().string(), frames.size()));
}

}  // namespace umax
