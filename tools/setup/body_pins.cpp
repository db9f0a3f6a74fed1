#include "tools/setup/body_pins.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "embedding/mesh_files/mesh_io.h"
#include "tools/setup/animated_mesh.h"
#include "tools/setup/named_error.h"
#include "tools/setup/pin_bones.h"

namespace umax {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double white = 0.999, black = 0.001;  // [-] of paint: exact from the one on, free up to the other
constexpr int residual_samples = 24;            // over the clip

[[noreturn]] void refuse(const std::string& where, const std::string& what, const std::string& value,
                         const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = where, .what = what, .value = value, .remedy = remedy});
}

// vertices of the body's mesh, and how much each is held: 0 ... 1
struct HeldVertices {
  std::vector<int> vertices;
  std::vector<double> weights;
};

HeldVertices vertices_in_region(const PinDescription& pin, const Points& vertices) {
  HeldVertices held;
  for (int v = 0; v < int(vertices.rows()); ++v) {
    const Vector3d p = vertices.row(v).transpose();
    const bool is_in = pin.box.min
                           ? (p.array() >= pin.box.min->array()).all() && (p.array() <= pin.box.max->array()).all()
                           : (p - *pin.sphere.centre).norm() <= *pin.sphere.radius;
    if (is_in) held.vertices.push_back(v), held.weights.push_back(1);
  }
  if (!held.vertices.empty()) return held;
  const Vector3d low = vertices.colwise().minCoeff(), high = vertices.colwise().maxCoeff();
  refuse(pin.box.min ? "box" : "sphere", "holds no point of the body", "",
         fmt::format("the body's surface reaches from [{:g}, {:g}, {:g}] to [{:g}, {:g}, {:g}] m", low.x(), low.y(),
                     low.z(), high.x(), high.y(), high.z()));
}

HeldVertices vertices_by_paint(const PinDescription& pin, Eigen::Index num_vertices) {
  const TriangleMesh painted = load_mesh(pin.map).mesh;
  if (painted.colors.rows() == 0)
    refuse("map", "has no painted vertices", pin.map.string(), "paint its vertices: black is free, white is held");
  if (painted.num_vertices() != num_vertices)
    refuse("map", fmt::format("has {} vertices, but the body's mesh has {}", painted.num_vertices(), num_vertices),
           pin.map.string(), "paint a copy of the very mesh that the body has");
  HeldVertices held;
  for (int v = 0; v < int(num_vertices); ++v) {
    const double weight = painted.colors.row(v).dot(Eigen::RowVector3d(0.2126, 0.7152, 0.0722));
    if (weight > black) held.vertices.push_back(v), held.weights.push_back(weight);
  }
  if (held.vertices.empty())
    refuse("map", "holds no point: all of it is black", pin.map.string(), "paint what is held in white");
  return held;
}

// a pin's points on the body's own vertices
void hold_vertices(const HeldVertices& held, const PinnedBody& body, Pin& pin, std::vector<double>& weights) {
  const EmbeddedPoints vertices = points_of(body.embedding);
  const auto count = Eigen::Index(held.vertices.size());
  pin.points.hex.resize(count);
  pin.points.weights.resize(count, 8);
  pin.rest.resize(count, 3);
  pin.motion.corners.resize(count, 3);
  pin.motion.shares.resize(count, 3);
  for (Eigen::Index p = 0; p < count; ++p) {
    const int v = held.vertices[std::size_t(p)];
    pin.points.hex[p] = vertices.hex[v];
    pin.points.weights.row(p) = vertices.weights.row(v);
    pin.rest.row(p) = body.shape.mesh.positions.row(v);
    pin.motion.corners.row(p).setConstant(v);
    pin.motion.shares.row(p) << 1, 0, 0;
  }
  pin.part = VectorXi::Zero(count);
  weights = held.weights;
}

// of each point's spring; of_hex: [N/m] stiffness of a hex
void set_stiffness(const PinDescription& description, const std::vector<double>& weights, double of_hex, Pin& pin) {
  std::map<int, int> in_hex;
  for (const int hex : pin.points.hex) ++in_hex[hex];
  pin.stiffness.resize(pin.points.size());
  for (Eigen::Index p = 0; p < pin.stiffness.size(); ++p) {
    const double weight = weights[std::size_t(p)], share = weight < white ? weight / (1 - weight) : 1;
    if (description.stiffness)
      pin.stiffness[p] = share * *description.stiffness;
    else
      pin.stiffness[p] = weight < white ? share * of_hex / in_hex[pin.points.hex[p]] : infinity;
  }
}

void set_motion(const Scene& scene, const PinDescription& description, const PinnedBody& body, const HeldByBones& held,
                Pin& pin, std::vector<std::string>& warnings) {
  pin.motion.preroll = scene.clip.preroll;
  if (description.from) pin.from = *description.from;
  if (description.until) pin.until = *description.until;
  if (!description.cache.path.empty()) {
    pin.motion.mesh = std::make_shared<const MeshMotion>(with_inner_points(
        read_motion(description.cache, held.vertices, body.shape.world_from_file, scene.clip, warnings), held.inner));
    return;
  }
  if (description.position) pin.motion.position = *description.position;
  if (description.rotation_degrees) pin.motion.rotation_degrees = *description.rotation_degrees;
  const Vector3d middle = 0.5 * (pin.rest.colwise().minCoeff() + pin.rest.colwise().maxCoeff()).transpose();
  pin.motion.pivot = description.pivot.value_or(middle);
}

FileVertices vertices_of(const PlacedMesh& shape) {
  const Eigen::Index count = shape.mesh.num_vertices();
  if (!shape.own) return {count, {}, count, shape.mesh.triangles};
  return {count, shape.own->vertex_in_file, count + shape.own->loose_vertices.rows(), shape.mesh.triangles};
}

Pin make_pin(const Scene& scene, const PinDescription& description, const PinnedBody& body,
             std::vector<std::string>& warnings) {
  Pin pin;
  pin.name = description.name;
  std::vector<double> weights;
  HeldByBones held{vertices_of(body.shape), {}};
  if (!description.inside.path.empty()) {
    held = hold_bones(description.inside, body.shape, body.lattice, pin, warnings);
    weights.assign(std::size_t(pin.rest.rows()), 1);
  } else {
    hold_vertices(description.map.empty() ? vertices_in_region(description, body.shape.mesh.positions)
                                          : vertices_by_paint(description, held.vertices.count),
                  body, pin, weights);
  }
  set_stiffness(description, weights, body.young * cell_of(body.lattice), pin);
  set_motion(scene, description, body, held, pin, warnings);
  return pin;
}

// the farthest that exact points are from where they should go, at instants of the clip
double largest_residual(const BodyPins& pins, const ClipDescription& clip) {
  double largest = 0;
  for (int k = 0; k <= residual_samples; ++k)
    largest = std::max(largest, pins.residual_at((clip.frames - 1) / clip.fps * k / residual_samples));
  return largest;
}

std::string describe(const BodyPins& pins, const ClipDescription& clip) {
  Eigen::Index points = 0;
  for (const Pin& pin : pins.pins()) points += pin.points.size();
  const std::vector<char> all(pins.pins().size(), 1);
  const bool is_one = pins.pins().size() == 1;
  std::string text = fmt::format("{} pin{} of {} points drive{} {} nodes", pins.pins().size(), is_one ? "" : "s",
                                 points, is_one ? "s" : "", pins.driven_nodes(all).size());
  if (pins.ever_has_springs()) text += is_one ? " and holds hexes by springs" : " and hold hexes by springs";
  return text + fmt::format("; points of driven hexes are within {:.2g} m of where they should go",
                            largest_residual(pins, clip));
}

// Says which pins are elsewhere than at rest when the clip begins.
void warn_of_jumps(const BodyPins& pins, const ClipDescription& clip, double cell, std::vector<std::string>& warnings) {
  if (clip.preroll > 0) return;
  for (const Pin& pin : pins.pins()) {
    const double farthest = (targets_at(pin, 0) - pin.rest).rowwise().norm().maxCoeff();
    if (pin.is_active(0) && farthest > 0.1 * cell)
      warnings.push_back(
          fmt::format("pin.{} is {:.3g} m away from rest when the clip begins, and pulls the body there "
                      "at once; clip.preroll leads it there",
                      pin.name, farthest));
  }
}

}  // namespace

std::shared_ptr<const BodyPins> body_pins(const Scene& scene, const PinnedBody& body, std::vector<std::string>& notes,
                                          std::vector<std::string>& warnings) {
  std::vector<Pin> pins;
  for (const PinDescription& description : scene.pins)
    if (description.body == body.name)
      named("body." + body.name + ".pin." + description.name, [&] {
        pins.push_back(make_pin(scene, description, body, warnings));
        return 0;
      });
  if (pins.empty()) return nullptr;
  auto made = std::make_shared<const BodyPins>(std::move(pins), body.lattice.rest_positions, body.lattice.hexes);
  notes.push_back(describe(*made, scene.clip));
  warn_of_jumps(*made, scene.clip, cell_of(body.lattice), warnings);
  return made;
}

}  // namespace umax
