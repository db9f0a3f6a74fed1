#include "tools/live/messages.h"

#include <nlohmann/json.hpp>

#include "tools/system/version.h"

namespace umax {
namespace {

using nlohmann::json;

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
          {"cells", can_set_cells(session, int(&body - &session.simulation.bodies[0]))},
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
             {"most_cells", most_live_cells},
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
