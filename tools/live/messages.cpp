#include "tools/live/messages.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/system/version.h"

namespace umax {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<const char*, Wish>, 18> words{{{"play", Wish::play},
                                                              {"pause", Wish::pause},
                                                              {"step", Wish::step},
                                                              {"restart", Wish::restart},
                                                              {"slower", Wish::slower},
                                                              {"set", Wish::set},
                                                              {"grab", Wish::grab},
                                                              {"move", Wish::move},
                                                              {"release", Wish::release},
                                                              {"show", Wish::show},
                                                              {"rewind", Wish::rewind},
                                                              {"save", Wish::save},
                                                              {"render", Wish::render},
                                                              {"lines", Wish::lines},
                                                              {"steer", Wish::steer},
                                                              {"seen", Wish::seen},
                                                              {"invite", Wish::invite},
                                                              {"place", Wish::place}}};

std::optional<Wish> wish_of(const json& value) {
  if (!value.is_string()) return std::nullopt;
  for (const auto& [word, wish] : words)
    if (value.get_ref<const std::string&>() == word) return wish;
  return std::nullopt;
}

bool take(const json& message, const char* name, int& number) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_number_integer()) return false;
  const auto value = found->get<std::int64_t>();
  if (value < 0 || value > 2000000000) return false;
  number = int(value);
  return true;
}

bool take(const json& message, const char* name, double& number) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_number()) return false;
  number = found->get<double>();
  return std::isfinite(number);
}

bool take(const json& message, const char* name, Vector3d& place) {
  const auto found = message.find(name);
  if (found == message.end() || !found->is_array() || found->size() != 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(*found)[i].is_number()) return false;
    place[Eigen::Index(i)] = (*found)[i].get<double>();
  }
  return place.allFinite();
}

/// The message's own fields; how many there must be, or none where one is missing.
std::optional<std::size_t> take_fields(const json& text, Message& message) {
  const auto all = [](std::size_t count, bool there) { return there ? std::optional(count) : std::nullopt; };
  switch (message.wish) {
    case Wish::slower:
      return all(1, take(text, "value", message.value) && message.value >= 1 && message.value <= 64);
    case Wish::set:
      return all(2, take(text, "key", message.key) && take(text, "value", message.value));
    case Wish::grab:
      return all(3, take(text, "body", message.body) && take(text, "vertex", message.vertex) &&
                        take(text, "place", message.place));
    case Wish::place:
      return all(2, take(text, "obstacle", message.obstacle) && take(text, "place", message.place));
    case Wish::move:
      return all(1, take(text, "place", message.place));
    case Wish::show:
    case Wish::rewind:
    case Wish::seen:
      return all(1, take(text, "frame", message.frame));
    default:
      return 0;
  }
}

const char* unit_of(const LiveKey& key) {
  switch (key.kind) {
    case LiveKind::limit:
      return key.unit == LimitUnit::stretch ? "%" : key.unit == LimitUnit::energy ? "J" : "J/m³";
    case LiveKind::young:
      return "kPa";
    case LiveKind::density:
      return "kg/m³";
    case LiveKind::damping_mass:
      return "1/s";
    case LiveKind::damping_stiffness:
      return "s";
    case LiveKind::gravity:
      return "m/s²";
    case LiveKind::friction:
      return "";
  }
  return "";
}

json json_of(const LiveKey& key) {
  const bool is_stretch = key.kind == LiveKind::limit && key.unit == LimitUnit::stretch;
  const double scale = is_stretch ? 100 : key.kind == LiveKind::young ? 1e-3 : 1;
  return {{"path", key.path},
          {"body", key.body},
          {"limit", key.kind == LiveKind::limit},
          {"unit", unit_of(key)},
          {"scale", scale},
          {"least", key.least},
          {"most", key.most},
          {"low", key.slider_low},
          {"high", key.slider_high},
          {"animated", key.is_animated},
          {"none", key.may_be_none ? json(no_limit) : json(nullptr)}};
}

json json_of(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
json json_of(const Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

json json_of(const Session& session, const BodySetup& body) {
  const Model::BodyRange& range = session.simulation.model.bodies[std::size_t(&body - &session.simulation.bodies[0])];
  return {{"name", body.name},
          {"vertices", body.embedding->hex.size()},
          {"triangles", body.shape.mesh.num_triangles()},
          {"hexes", range.num_hexes},
          {"nodes", range.num_nodes},
          {"mass", session.simulation.model.node_mass.segment(range.first_node, range.num_nodes).sum()},
          {"color", json_of(body.look.base_color)}};
}

json json_of(const Session& session, std::size_t i) {
  const Obstacle& obstacle = session.simulation.model.obstacles[i];
  const ObstacleDescription& description = session.simulation.scene.obstacles[i];
  const Pose pose = pose_at(obstacle, 0);
  json matrix = json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) matrix.push_back(pose.rotation(row, column));
  return {{"name", obstacle.name},
          {"plane", std::holds_alternative<HalfSpace>(obstacle.shape)},
          {"visible", description.visible},
          {"deforms", obstacle.deformation != nullptr},
          {"movable", can_place(session.original, i)},
          {"place", json_of(pose.translation)},
          {"turn", matrix},
          {"color", json_of(description.look.base_color)}};
}

/// A pin, whose handle stands behind those of the obstacles.
json json_of_pin(const Session& session, std::size_t pin) {
  const Simulation& simulation = session.simulation;
  const std::size_t handle = simulation.model.obstacles.size() + pin;
  const PinDescription& description = simulation.scene.pins[pin];
  double size = 0;
  for (const BodySetup& body : simulation.bodies)
    if (body.name == description.body)
      size = (body.lattice.rest_positions.colwise().maxCoeff() - body.lattice.rest_positions.colwise().minCoeff())
                 .maxCoeff();
  return {{"name", description.body + "." + description.name},
          {"movable", can_place(session.original, handle)},
          {"place", json_of(place_at(simulation, handle, session.state.time))},
          {"radius", 0.03 * size}};
}

json values_of(const Session& session) {
  json values = json::array();
  for (std::size_t i = 0; i < session.keys.size(); ++i) values.push_back(value_now(session, i));
  return values;
}

}  // namespace

std::optional<Message> decode_message(std::string_view text) {
  if (text.size() > longest_message) return std::nullopt;
  const json parsed = json::parse(text, nullptr, false);
  if (!parsed.is_object()) return std::nullopt;
  const auto word = parsed.find("wish");
  if (word == parsed.end()) return std::nullopt;
  const std::optional<Wish> wish = wish_of(*word);
  if (!wish) return std::nullopt;
  Message message{.wish = *wish};
  const std::optional<std::size_t> fields = take_fields(parsed, message);
  if (!fields || parsed.size() != *fields + 1) return std::nullopt;
  return message;
}

bool needs_steering(Wish wish) {
  return wish != Wish::lines && wish != Wish::steer && wish != Wish::seen && wish != Wish::invite;
}

std::string hello_text(const Session& session, int keep) {
  const Simulation& simulation = session.simulation;
  json hello{{"type", "hello"},
             {"name", simulation.scene.name},
             {"version", version_text()},
             {"time_step", simulation.options.time_step},
             {"substeps", session.substeps()},
             {"fps", simulation.scene.clip.fps},
             {"tolerance", simulation.options.solver.tolerance},
             {"can_grab", can_grab(session)},
             {"keep", keep}};
  for (const BodySetup& body : simulation.bodies) hello["bodies"].push_back(json_of(session, body));
  hello["obstacles"] = json::array();
  for (std::size_t i = 0; i < simulation.model.obstacles.size(); ++i) hello["obstacles"].push_back(json_of(session, i));
  hello["pins"] = json::array();
  for (std::size_t i = 0; i < simulation.scene.pins.size(); ++i) hello["pins"].push_back(json_of_pin(session, i));
  for (const LiveKey& key : session.keys) hello["keys"].push_back(json_of(key));
  hello["values"] = values_of(session);
  hello["goals"] = session.goals;
  return hello.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string values_text(const Session& session) {
  return json{{"type", "values"}, {"values", values_of(session)}, {"goals", session.goals}}.dump();
}

std::string told_text(const std::string& kind, const std::string& text) {
  return json{{"type", kind}, {"text", text}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string role_text(bool steers, int watchers) {
  return json{{"type", "role"}, {"steers", steers}, {"watchers", watchers}}.dump();
}

}  // namespace umax
