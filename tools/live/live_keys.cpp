#include "tools/live/live_keys.h"

#include <algorithm>
#include <cmath>

#include "core/model/pins.h"
#include "tools/setup/limit_report.h"

namespace umax {
namespace {

constexpr double fastest_fall = 0.5;  // [1/s] of stretch

// the key's track in bodies as scenes describe them, and as the model has them
template <class BodyLike>
auto& track_of(const LiveKey& key, BodyLike& body) {
  switch (key.kind) {
    case LiveKind::young:
      return body.material.young;
    case LiveKind::density:
      return body.material.density;
    case LiveKind::damping_mass:
      return body.material.damping_mass;
    case LiveKind::damping_stiffness:
      return body.material.damping_stiffness;
    default:
      return limit_on(body.limit, body.part_limits, key.part).value;
  }
}

Track<double>& track_in(const LiveKey& key, BodyDescription& body) {
  return key.kind == LiveKind::friction ? body.friction : track_of(key, body);
}
const Track<double>& track_in(const LiveKey& key, const BodyDescription& body) {
  return key.kind == LiveKind::friction ? body.friction : track_of(key, body);
}
Track<double>& track_in(const LiveKey& key, Model::BodyRange& body) {
  return key.kind == LiveKind::friction ? body.friction_keys : track_of(key, body);
}

template <class T>
void cut(double time, Track<T>& track) {
  if (track.interpolation != Interpolation::hold) return;
  while (track.times.size() > 1 && track.times.back() >= time) track.times.pop_back(), track.values.pop_back();
  if (track.is_constant()) track = Track<T>(T(track.values.front()));
}

template <class T>
void hold(double time, const T& value, Track<T>& track) {
  cut(time, track);
  if (track.values.back() == value) return;
  track.interpolation = Interpolation::hold;
  track.times.push_back(time);
  track.values.push_back(value);
}

template <class T>
bool has_own_keys(const Track<T>& track) {
  return !track.is_constant();
}

const char* name_of(LimitUnit unit) {
  return unit == LimitUnit::energy ? "energy" : unit == LimitUnit::density ? "density" : "stretch";
}

void add_limits(const BodyDescription& body, int number, std::vector<LiveKey>& keys) {
  for (const EnergyPart part : {EnergyPart::whole, EnergyPart::volumetric, EnergyPart::deviatoric, EnergyPart::fibre}) {
    const EnergyLimitOptions& limit = limit_on(body.limit, body.part_limits, part);
    if (limit.kind == LimitKind::none) continue;
    LiveKey key{.path = "body." + body.name + "." + limit_name(part) + "." + name_of(limit.unit),
                .kind = LiveKind::limit,
                .body = number,
                .part = part,
                .unit = limit.unit,
                .is_animated = has_own_keys(limit.value)};
    const double now = limit.value.at(0);
    key.least = limit.unit == LimitUnit::stretch ? 1e-3 : 1e-6 * now;
    key.most = limit.unit == LimitUnit::stretch ? 1 : 1e6 * now;
    key.slider_low = limit.unit == LimitUnit::stretch ? 0.005 : 1e-3 * now;
    key.slider_high = limit.unit == LimitUnit::stretch ? 1 : 1e3 * now;
    if (limit.unit == LimitUnit::stretch && now >= no_limit) {
      key.may_be_none = true;
      key.most = no_limit;
    }
    keys.push_back(key);
  }
}

void add_materials(const BodyDescription& body, int number, std::vector<LiveKey>& keys) {
  const auto add = [&](const char* name, LiveKind kind, const Track<double>& track, double least, double most,
                       double low, double high) {
    keys.push_back({.path = "body." + body.name + "." + name,
                    .kind = kind,
                    .body = number,
                    .least = least,
                    .most = most,
                    .slider_low = low,
                    .slider_high = high,
                    .is_animated = has_own_keys(track)});
  };
  const MaterialOptions& material = body.material;
  add("material.young", LiveKind::young, material.young, 1, 1e12, 1e3, 1e8);
  add("material.density", LiveKind::density, material.density, 1e-3, 1e6, 10, 1e4);
  add("material.damping_mass", LiveKind::damping_mass, material.damping_mass, 0, 1e4, 1e-2, 100);
  add("material.damping_stiffness", LiveKind::damping_stiffness, material.damping_stiffness, 0, 100, 1e-5, 1);
  add("friction", LiveKind::friction, body.friction, 0, 1000, 1e-2, 10);
}

LiveKey gravity_key(const ClipDescription& clip) {
  LiveKey key{.path = "clip.gravity",
              .kind = LiveKind::gravity,
              .least = 0,
              .most = 1e4,
              .slider_low = 0.1,
              .slider_high = 100,
              .is_animated = has_own_keys(clip.gravity)};
  const Vector3d start = clip.gravity.at(0);
  if (start.norm() > 0) key.direction = start.normalized();
  return key;
}

// a pin of the scene among those of its body
struct PlacedPin {
  const Model::BodyRange* body = nullptr;
  std::size_t number = 0;
  const Pin& pin() const { return body->pins->pins()[number]; }
};

PlacedPin find_pin(const Simulation& simulation, std::size_t pin) {
  const std::string& name = simulation.scene.pins[pin].body;
  PlacedPin found;
  for (const Model::BodyRange& body : simulation.model.bodies)
    if (body.name == name) found.body = &body;
  for (std::size_t i = 0; i < pin; ++i) found.number += simulation.scene.pins[i].body == name;
  return found;
}

Vector3d middle_of(const Pin& pin) {
  return 0.5 * (pin.rest.colwise().minCoeff() + pin.rest.colwise().maxCoeff()).transpose();
}

// changes the track of a pin's place in the scene and in the model alike, if it changes it
template <class Change>
void change_pin(std::size_t pin, Simulation& simulation, const Change& change) {
  const PlacedPin placed = find_pin(simulation, pin);
  Track<Vector3d> track = placed.pin().motion.position;
  change(track);
  if (track == placed.pin().motion.position) return;
  simulation.scene.pins[pin].position = track;
  Model::BodyRange& body = simulation.model.bodies[std::size_t(placed.body - simulation.model.bodies.data())];
  body.pins = std::make_shared<const BodyPins>(*body.pins, placed.number, track);
}

// the stretch that a limit means
double stretch_of(const LiveKey& key, const Simulation& simulation, double value, double time) {
  const auto body = std::size_t(key.body);
  return stretch_of_limit(simulation.scene.bodies[body], key.part, value, time,
                          mean_hex_volume(simulation.bodies[body].lattice));
}

}  // namespace

double LiveKey::value_at(const Scene& scene, double time) const {
  if (kind == LiveKind::gravity) return scene.clip.gravity.at(time).dot(direction);
  return track_in(*this, scene.bodies[std::size_t(body)]).at(time);
}

Scene with_turnable_limits(Scene scene) {
  if (scene.solver.method != SolverMethod::exact) return scene;
  for (BodyDescription& body : scene.bodies)
    if (body.limit.kind == LimitKind::none)
      body.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = Track<double>(no_limit)};
  return scene;
}

std::vector<LiveKey> live_keys(const Scene& scene) {
  std::vector<LiveKey> keys;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    add_limits(scene.bodies[i], int(i), keys);
    add_materials(scene.bodies[i], int(i), keys);
  }
  keys.push_back(gravity_key(scene.clip));
  return keys;
}

void hold_from(const LiveKey& key, double time, double value, Simulation& simulation) {
  if (key.kind == LiveKind::gravity) {
    hold(time, Vector3d(value * key.direction), simulation.scene.clip.gravity);
    return;
  }
  hold(time, value, track_in(key, simulation.scene.bodies[std::size_t(key.body)]));
  hold(time, value, track_in(key, simulation.model.bodies[std::size_t(key.body)]));
}

void drop_from(const LiveKey& key, double time, Simulation& simulation) {
  if (key.is_animated) return;
  if (key.kind == LiveKind::gravity) {
    cut(time, simulation.scene.clip.gravity);
    return;
  }
  cut(time, track_in(key, simulation.scene.bodies[std::size_t(key.body)]));
  cut(time, track_in(key, simulation.model.bodies[std::size_t(key.body)]));
}

std::size_t count_handles(const Scene& scene) {
  return scene.obstacles.size() + scene.pins.size();
}

bool can_place(const Scene& original, std::size_t handle) {
  if (handle >= original.obstacles.size()) {
    const PinDescription& pin = original.pins[handle - original.obstacles.size()];
    return pin.cache.path.empty() && (!pin.position || pin.position->is_constant());
  }
  const ObstacleDescription& of = original.obstacles[handle];
  return !std::holds_alternative<HalfSpace>(of.shape) && of.cache.path.empty() && of.position.is_constant();
}

Vector3d place_at(const Simulation& simulation, std::size_t handle, double time) {
  if (handle < simulation.model.obstacles.size()) return simulation.model.obstacles[handle].position.at(time);
  const Pin& pin = find_pin(simulation, handle - simulation.model.obstacles.size()).pin();
  return middle_of(pin) + pin.motion.position.at(time);
}

void place_from(std::size_t handle, double time, const Vector3d& place, Simulation& simulation) {
  if (handle < simulation.model.obstacles.size()) {
    hold(time, place, simulation.scene.obstacles[handle].position);
    hold(time, place, simulation.model.obstacles[handle].position);
    return;
  }
  const std::size_t pin = handle - simulation.model.obstacles.size();
  change_pin(pin, simulation, [&](Track<Vector3d>& track) {
    hold(time, Vector3d(place - middle_of(find_pin(simulation, pin).pin())), track);
  });
}

void drop_places_from(const Scene& original, double time, Simulation& simulation) {
  for (std::size_t i = 0; i < count_handles(original); ++i) {
    if (!can_place(original, i)) continue;
    if (i >= original.obstacles.size()) {
      change_pin(i - original.obstacles.size(), simulation, [&](Track<Vector3d>& track) { cut(time, track); });
      continue;
    }
    cut(time, simulation.scene.obstacles[i].position);
    cut(time, simulation.model.obstacles[i].position);
  }
}

double limit_after_step(const LiveKey& key, const Simulation& simulation, double now, double goal, double time,
                        double time_step) {
  if (goal >= now) return goal;
  const double from = stretch_of(key, simulation, now, time), to = stretch_of(key, simulation, goal, time);
  const double reached = std::max(to, from - fastest_fall * time_step);
  if (reached <= to) return goal;
  return key.unit == LimitUnit::stretch ? reached : now * (reached / from) * (reached / from);
}

}  // namespace umax
