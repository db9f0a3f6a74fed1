#include "tools/pictures/motion_blur.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/model/deformation.h"
#include "tools/pictures/drawn_surface.h"

namespace umax {
namespace {

// between two instants of what turns; more of them follow the circle better
constexpr double largest_turn = 3.14159265358979 / 36;

/// Nodes of a body in one state.
auto nodes_of(const BodySetup& body, const State& state) {
  return state.positions.middleRows(body.first_node, body.lattice.num_nodes());
}

std::shared_ptr<const TriangleMesh> surface_at(const Simulation& simulation, const BodySetup& body,
                                               const State& state) {
  auto surface = std::make_shared<TriangleMesh>();
  draw_surface(simulation, body, nodes_of(body, state), *surface);
  return surface;
}

bool is_at_rest(const BodySetup& body, const std::vector<State>& states) {
  return std::all_of(states.begin(), states.end(),
                     [&](const State& state) { return nodes_of(body, state) == nodes_of(body, states.front()); });
}

/// drawn: of the frame's own state.
void add_body_motion(const Simulation& simulation, const BodySetup& body, const std::vector<State>& states,
                     const Exposure& exposure, int frame, RenderObject& drawn) {
  if (is_at_rest(body, states)) return;
  SurfaceMotion& motion = drawn.motion;
  motion.first = exposure.share(exposure.first_state());
  motion.last = exposure.share(exposure.last_state());
  for (int k = exposure.first_state(); k <= exposure.last_state(); ++k)
    motion.instants.push_back(
        k == frame ? drawn.mesh : surface_at(simulation, body, states[std::size_t(k - exposure.first_state())]));
}

bool is_same(const Pose& a, const Pose& b) {
  return a.translation == b.translation && a.rotation == b.rotation;
}

double turn_between(const Pose& a, const Pose& b) {
  const double cosine = ((a.rotation.transpose() * b.rotation).trace() - 1) / 2;
  return std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// Does the obstacle's own shape change in that time, and into how many even parts must it be cut to be followed?
int parts_of_deformation(const Obstacle& obstacle, double begin, double end) {
  constexpr int parts_of_sample = 2, most_parts = 64;
  if (!obstacle.deformation) return 0;
  const std::vector<double>& times = obstacle.deformation->motion().times;
  if (end <= times.front() || begin >= times.back()) return 0;
  const auto samples =
      std::upper_bound(times.begin(), times.end(), end) - std::lower_bound(times.begin(), times.end(), begin);
  return std::min(int(samples + 1) * parts_of_sample, most_parts);
}

/// Even times at which the obstacle is drawn, as many as its turning and its deformation need; none when it stands still.
std::vector<double> times_while_open(const Obstacle& obstacle, double begin, double end) {
  const auto time_of = [&](int k, int count) { return begin + (end - begin) * k / count; };
  const auto poses = [&](int count) {
    std::vector<Pose> found;
    for (int k = 0; k <= count; ++k) found.push_back(pose_at(obstacle, time_of(k, count)));
    return found;
  };
  const std::vector<Pose> few = poses(8);
  double turn = 0;
  bool moves = false;
  for (std::size_t k = 1; k < few.size(); ++k) {
    turn += turn_between(few[k - 1], few[k]);
    moves = moves || !is_same(few[k], few[0]);
  }
  const int deformations = parts_of_deformation(obstacle, begin, end);
  const int count = std::max(moves ? std::clamp(int(std::ceil(turn / largest_turn)), 2, 64) : 0, deformations);
  std::vector<double> times;
  for (int k = 0; count > 0 && k <= count; ++k) times.push_back(time_of(k, count));
  return times;
}

}  // namespace

void add_motion(const Simulation& simulation, const Stage& stage, const std::vector<State>& states,
                const Exposure& exposure, int frame, RenderScene& shot) {
  if (!exposure.is_open()) return;
  shot.moment = exposure.share(frame);
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i)
    add_body_motion(simulation, simulation.bodies[i], states, exposure, frame, shot.objects[i]);

  const double now = states[std::size_t(frame - exposure.first_state())].time;
  const auto time_of = [&](double place) { return now + (place - frame) / simulation.scene.clip.fps; };
  std::size_t object = simulation.bodies.size();
  for (std::size_t i = 0; i < simulation.obstacles.size(); ++i) {
    if (!simulation.scene.obstacles[i].visible) continue;
    SurfaceMotion& motion = shot.objects[object++].motion;
    const Obstacle& obstacle = simulation.model.obstacles[i];
    for (const double time : times_while_open(obstacle, time_of(exposure.opens), time_of(exposure.closes)))
      motion.instants.push_back(std::make_shared<const TriangleMesh>(
          moved(*obstacle_surface(simulation, stage, i, time), pose_at(obstacle, time))));
  }
}

void add_neighbours(const Simulation& simulation, const Stage& stage, const std::vector<State>& states,
                    const StateWindow& window, int frame, RenderScene& shot) {
  if (!simulation.scene.render.has_layer(PictureLayer::vector)) return;
  const State& now = states[std::size_t(frame - window.first)];
  const auto place = [&](int neighbour, auto member) {
    if (neighbour < window.first || neighbour > window.last) return;
    const State& state = states[std::size_t(neighbour - window.first)];
    for (std::size_t i = 0; i < simulation.bodies.size(); ++i)
      if (nodes_of(simulation.bodies[i], state) != nodes_of(simulation.bodies[i], now))
        shot.objects[i].*member = surface_at(simulation, simulation.bodies[i], state);
    std::size_t object = simulation.bodies.size();
    for (std::size_t i = 0; i < simulation.obstacles.size(); ++i) {
      if (!simulation.scene.obstacles[i].visible) continue;
      RenderObject& drawn = shot.objects[object++];
      const Pose then = pose_at(simulation.model.obstacles[i], state.time);
      const std::shared_ptr<const TriangleMesh> surface = obstacle_surface(simulation, stage, i, state.time);
      if (!is_same(then, pose_at(simulation.model.obstacles[i], now.time)) ||
          surface != obstacle_surface(simulation, stage, i, now.time))
        drawn.*member = std::make_shared<const TriangleMesh>(moved(*surface, then));
    }
  };
  place(frame - 1, &RenderObject::previous);
  place(frame + 1, &RenderObject::next);
}

void add_camera_motion(const Exposure& exposure, const std::function<Camera(double frame)>& camera_at,
                       RenderScene& shot) {
  if (!exposure.is_open()) return;
  constexpr int segments = 8;
  for (int k = 0; k <= segments; ++k)
    shot.camera_path.push_back(camera_at(exposure.opens + (exposure.closes - exposure.opens) * k / segments));
}

}  // namespace umax
