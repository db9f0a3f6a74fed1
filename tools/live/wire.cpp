#include "tools/live/wire.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "embedding/surface/normals.h"
#include "tools/pictures/heat.h"
#include "tools/setup/byte_writer.h"

namespace umax {
namespace {

constexpr std::size_t most_points = 96;  // of contacts that are shown
constexpr double steps_of_place = 65535;

struct Box {
  std::array<float, 3> low{}, extent{};
};

Box box_of(const Eigen::Ref<const Points>& places) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[std::size_t(axis)] = std::nextafter(float(places.col(axis).minCoeff()), -1e30f);
    const double high = places.col(axis).maxCoeff();
    box.extent[std::size_t(axis)] =
        std::nextafter(std::max(1e-6f, float(high - double(box.low[std::size_t(axis)]))), 1e30f);
  }
  return box;
}

Box join(const std::vector<Box>& boxes) {
  Box all = boxes.front();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float high = all.low[axis] + all.extent[axis];
    for (const Box& box : boxes) {
      all.low[axis] = std::min(all.low[axis], box.low[axis]);
      high = std::max(high, box.low[axis] + box.extent[axis]);
    }
    all.extent[axis] = high - all.low[axis];
  }
  return all;
}

void put_place(ByteWriter& out, const Box& box, const Vector3d& place) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double share = (place[Eigen::Index(axis)] - double(box.low[axis])) / double(box.extent[axis]);
    out.put(std::uint16_t(std::lround(steps_of_place * std::clamp(share, 0.0, 1.0))));
  }
}

void pad(ByteWriter& out) {
  out.bytes.resize((out.bytes.size() + 3) / 4 * 4);
}

std::vector<Box> put_nodes(ByteWriter& out, const Model& model, const State& state) {
  std::vector<Box> boxes;
  for (const Model::BodyRange& body : model.bodies) {
    const auto places = state.positions.middleRows(body.first_node, body.num_nodes);
    const Box box = box_of(places);
    for (const float value : box.low) out.put(value);
    for (const float value : box.extent) out.put(value);
    for (Eigen::Index i = 0; i < places.rows(); ++i) put_place(out, box, places.row(i).transpose());
    pad(out);
    boxes.push_back(box);
  }
  return boxes;
}

std::uint8_t byte_of(double value) {
  return std::uint8_t(std::lround(std::clamp(value, 0.0, 255.0)));
}

void put_heat(ByteWriter& out, const Simulation& simulation, const State& state, FrameHeader& header) {
  const VectorXd energy = heat_values(simulation, state, Heatmap::energy);
  const VectorXd stretch = heat_values(simulation, state, Heatmap::stretch);
  const VectorXd multiplier = heat_values(simulation, state, Heatmap::multiplier);
  header.largest_stretch = float(std::max(1e-3, stretch.maxCoeff()));
  header.largest_multiplier = float(multiplier.maxCoeff());
  for (const double value : energy) out.put(byte_of(200 * value));
  for (const double value : stretch) out.put(byte_of(255 * value / double(header.largest_stretch)));
  if (header.largest_multiplier > 0) {
    header.flags |= flag_multipliers;
    const double top = std::log1p(double(header.largest_multiplier));
    for (const double value : multiplier) out.put(byte_of(255 * std::log1p(value) / top));
  }
  pad(out);
}

/// Points of bodies that push against something: where they are now, evenly chosen where there are many.
std::vector<Vector3d> contact_places(const Model& model, const State& state) {
  std::vector<Vector3d> places;
  const std::size_t stride = std::max<std::size_t>(1, (state.contacts.size() + most_points - 1) / most_points);
  for (std::size_t i = 0; i < state.contacts.size(); i += stride) {
    const State::ContactImpulse& contact = state.contacts[i];
    if (contact.point.kind == ContactKind::obstacle_edge || contact.impulse.isZero()) continue;
    const Eigen::Index point = contact.point.index;
    places.emplace_back(hex_nodes(model, state.positions, surface_hex(model, point)).transpose() *
                        surface_weights(model, point));
  }
  return places;
}

// planes stay where they are unless the scene moves them
bool may_move(const Obstacle& obstacle) {
  return !std::holds_alternative<HalfSpace>(obstacle.shape) || !obstacle.position.is_constant() ||
         !obstacle.rotation_degrees.is_constant();
}

void put_pose(ByteWriter& out, std::size_t handle, const Matrix3d& rotation, const Vector3d& place) {
  out.put(std::uint32_t(handle));
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) out.put(float(rotation(row, column)));
  for (const double coordinate : place) out.put(float(coordinate));
}

/// Obstacles, and pins that can be moved.
std::uint16_t put_moving(ByteWriter& out, const Session& session, double time) {
  const Model& model = session.simulation.model;
  std::uint16_t count = 0;
  for (std::size_t i = 0; i < model.obstacles.size(); ++i) {
    if (!may_move(model.obstacles[i])) continue;
    const Pose pose = pose_at(model.obstacles[i], time);
    put_pose(out, i, pose.rotation, pose.translation);
    ++count;
  }
  for (std::size_t i = model.obstacles.size(); i < count_handles(session.original); ++i) {
    if (!can_place(session.original, i)) continue;
    put_pose(out, i, Matrix3d::Identity(), place_at(session.simulation, i, time));
    ++count;
  }
  return count;
}

void fill(const Session& session, const State& state, const StepReport& report, const FrameInfo& info,
          FrameHeader& header) {
  header.status = std::uint8_t(report.status);
  header.flags = std::uint8_t((info.plays ? flag_plays : 0) | (info.is_past ? flag_past : 0) |
                              (session.grab ? flag_grabbed : 0) | (info.is_behind ? flag_behind : 0));
  header.num_bodies = std::uint8_t(session.simulation.bodies.size());
  header.number = info.number;
  header.step = std::uint32_t(state.step);
  header.frame = std::uint32_t(state.step / session.substeps() + 1);
  header.first_kept = info.first_kept;
  header.last_kept = info.last_kept;
  header.steps_not_converged = std::uint32_t(session.steps_not_converged);
  header.time = float(state.time);
  header.rate = float(info.rate);
  header.step_ms = float(info.step_ms);
  header.max_ratio = float(report.max_energy_ratio);
  header.kinetic = float(report.kinetic_energy);
  header.elastic = float(report.elastic_energy);
  header.potential = float(report.potential_energy);
  header.penetration = float(report.max_penetration);
  header.residual = float(report.kkt_residual);
  const auto count = [](int n) { return std::uint16_t(std::clamp(n, 0, 65535)); };
  header.limits_active = count(report.limits_active);
  header.contacts = count(report.contacts);
  header.iterations = count(report.sqp_iterations);
  header.retries = count(report.retries);
}

void fill_grab(const Session& session, const State& state, FrameHeader& header) {
  if (!session.grab) return;
  const BodySetup& body = session.simulation.bodies[std::size_t(session.grab->body)];
  const Eigen::Index vertex = session.grab->vertex;
  const Vector3d local = 2 * body.embedding->local.row(vertex).transpose().array() - 1;
  const Vector3d held =
      hex_nodes(session.simulation.model, state.positions, body.first_hex + body.embedding->hex[vertex]).transpose() *
      shape_functions(local);
  for (int axis = 0; axis < 3; ++axis) {
    header.grab[axis] = float(session.grab->goal[axis]);
    header.held[axis] = float(held[axis]);
  }
}

std::uint16_t coordinate(double value) {
  return std::uint16_t(std::lround(steps_of_place * std::clamp(value, 0.0, 1.0)));
}

Vector3f texel_of(const Image& image, const Eigen::RowVector2f& place) {
  const auto wrapped = [](float share, int size) {
    return std::clamp(int((share - std::floor(share)) * float(size)), 0, size - 1);
  };
  const float* pixel = image.pixel(wrapped(place.x(), image.width), wrapped(1 - place.y(), image.height));
  return image.channels < 3 ? Vector3f::Constant(pixel[0]) : Vector3f(pixel[0], pixel[1], pixel[2]);
}

/// Linear colours of vertices: the mesh's own, or those of their last triangle's material and picture.
std::vector<Vector3f> vertex_colors(const BodySetup& body) {
  const TriangleMesh& mesh = body.shape.mesh;
  const Look& look = body.look;
  std::vector<Vector3f> colors(std::size_t(mesh.num_vertices()), look.base_color);
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const bool is_painted = !look.paints.empty() && !mesh.materials.empty();
    const Paint paint = is_painted ? look.paints[std::size_t(mesh.materials[std::size_t(t)])]
                                   : Paint{look.base_color, look.texture, {}};
    const bool has_picture = paint.texture && mesh.texture_coordinates.rows() == 3 * mesh.num_triangles();
    for (int k = 0; k < 3; ++k) {
      Vector3f& color = colors[std::size_t(mesh.triangles(t, k))];
      color = paint.base_color;
      if (has_picture) color = color.cwiseProduct(texel_of(*paint.texture, mesh.texture_coordinates.row(3 * t + k)));
    }
  }
  if (look.vertex_colors)
    for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v)
      colors[std::size_t(v)] = mesh.colors.row(v).transpose().cast<float>();
  return colors;
}

/// The colour is put where numbers leave room.
void put_vertex(ByteWriter& out, const Model& model, const BodySetup& body, const TriangleMesh& rest,
                const Vector3f& color, Eigen::Index vertex) {
  const Eigen::Index hex = body.embedding->hex[vertex];
  const Vector3d local = body.embedding->local.row(vertex).transpose();
  out.put(std::uint32_t(hex));
  for (const double value : local) out.put(coordinate(value));
  const auto coded = [&](int channel) { return byte_of(255 * std::sqrt(std::max(0.0, double(color[channel])))); };
  out.put_all(coded(0), coded(1));
  const Vector3d s = 2 * local.array() - 1;
  const Matrix3d J = hex_nodes(model, model.rest_positions, body.first_hex + hex).transpose() * shape_gradients(s);
  Vector3d normal = J.transpose() * rest.normals.row(vertex).transpose();
  normal /= std::max(1e-30, normal.cwiseAbs().maxCoeff());
  for (const double value : normal) out.put(std::int8_t(std::lround(127 * value)));
  out.put(coded(2));
}

}  // namespace

std::string encode_body(const Simulation& simulation, std::size_t number) {
  const BodySetup& body = simulation.bodies[number];
  const Model::BodyRange& range = simulation.model.bodies[number];
  TriangleMesh rest = body.shape.mesh;
  compute_normals(rest);
  ByteWriter out;
  out.bytes = "UMXB";
  out.put_all(std::uint32_t(rest.num_vertices()), std::uint32_t(rest.num_triangles()), std::uint32_t(range.num_hexes),
              std::uint32_t(range.num_nodes));
  for (int e = 0; e < range.num_hexes; ++e)
    for (int n = 0; n < 8; ++n)
      out.put(std::uint32_t(simulation.model.hexes(range.first_hex + e, n) - range.first_node));
  const std::vector<Vector3f> colors = vertex_colors(body);
  for (Eigen::Index v = 0; v < rest.num_vertices(); ++v)
    put_vertex(out, simulation.model, body, rest, colors[std::size_t(v)], v);
  for (const int corner : rest.triangles.reshaped<Eigen::RowMajor>()) out.put(std::uint32_t(corner));
  return std::move(out.bytes);
}

std::string encode_obstacle(const Simulation& simulation, std::size_t obstacle) {
  static const TriangleMesh nothing;
  const auto& mesh = simulation.obstacles[obstacle].mesh;
  const TriangleMesh& shown = mesh ? *mesh : nothing;
  ByteWriter out;
  out.bytes = "UMXO";
  out.put_all(std::uint32_t(shown.num_vertices()), std::uint32_t(shown.num_triangles()));
  for (Eigen::Index v = 0; v < shown.num_vertices(); ++v)
    for (int axis = 0; axis < 3; ++axis) out.put(float(shown.positions(v, axis)));
  for (const int corner : shown.triangles.reshaped<Eigen::RowMajor>()) out.put(std::uint32_t(corner));
  return std::move(out.bytes);
}

std::string encode_frame(const Session& session, const State& state, const StepReport& report, const FrameInfo& info) {
  const Model& model = session.simulation.model;
  FrameHeader header;
  fill(session, state, report, info, header);
  fill_grab(session, state, header);
  ByteWriter out;
  out.bytes.reserve(sizeof header + std::size_t(6 * model.num_nodes() + 3 * model.num_hexes()) + 1024);
  out.bytes.resize(sizeof header);
  const std::vector<Box> boxes = put_nodes(out, model, state);
  put_heat(out, session.simulation, state, header);
  const Box all = join(boxes);
  const std::vector<Vector3d> points = contact_places(model, state);
  header.num_points = std::uint16_t(points.size());
  for (const Vector3d& point : points) put_place(out, all, point);
  pad(out);
  header.num_moving = put_moving(out, session, state.time);
  std::memcpy(out.bytes.data(), &header, sizeof header);
  return std::move(out.bytes);
}

Points decode_places(const std::string& frame, const Model& model) {
  Points places(model.num_nodes(), 3);
  const char* at = frame.data() + sizeof(FrameHeader);
  for (const Model::BodyRange& body : model.bodies) {
    std::array<float, 6> box{};
    std::memcpy(box.data(), at, sizeof box);
    at += sizeof box;
    for (Eigen::Index i = 0; i < body.num_nodes; ++i)
      for (int axis = 0; axis < 3; ++axis, at += 2) {
        std::uint16_t value = 0;
        std::memcpy(&value, at, 2);
        places(body.first_node + i, axis) =
            double(box[std::size_t(axis)]) + double(box[std::size_t(axis) + 3]) * value / steps_of_place;
      }
    at += body.num_nodes % 2 * 2;
  }
  return places;
}

}  // namespace umax
