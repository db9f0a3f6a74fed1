#include "core/contact/surface_overlap.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/contact/contact_support.h"
#include "core/contact/meeting.h"

namespace umax {
namespace {

constexpr double rim = 0.5;      // [cells] around vertices inside a body, where others come in as these go out
constexpr double one_way = 0.6;  // [-] of the depths of vertices in a body, that their ways out have in common

// Calls visit(i, vertex, held, touch) for each vertex of encounter i that is inside a body, in parallel by encounter.
template <class Visit>
void visit_inside(const Search& search, const Visit& visit) {
  const LastApart apart(search.positions);
  for_each_encounter(search, [&](std::size_t i, const Encounter&) {
    visit_held(meet(search, apart, i), [&](int vertex, const HeldVertex& held) {
      const Touch touch = measure(*search.step.model, held, {});
      if (touch.gap < 0) visit(i, vertex, held, touch);
    });
  });
}

// where a part of a body is: the mean of its vertices
struct PartPlace {
  Vector3d sum = Vector3d::Zero();  // [m]
  double vertices = 0;
  Vector3d mean() const { return sum / vertices; }
};

// ways of two bodies out of each other, weighted by depth
struct WaySum {
  Vector3d ways = Vector3d::Zero();  // [m] of the first body, depth by normal
  Matrix3d axes = Matrix3d::Zero();  // [m] depth by normal and normal
  double depths = 0;                 // [m]
  Eigen::AlignedBox3d where;
  PartPlace first, second;  // of hexes with vertices in the other body
};

// the same of one hex's vertices
struct HexWays {
  WaySum sum;
  double deepest = 0;  // [m]
  Contact contact;     // of the deepest
};

void add_vertex(const Model& model, const Points& positions, int vertex, const HeldVertex& held, const Touch& touch,
                HexWays& of_hex) {
  const double depth = -touch.gap;
  of_hex.sum.ways += depth * touch.normal;
  of_hex.sum.axes += depth * touch.normal * touch.normal.transpose();
  of_hex.sum.depths += depth;
  of_hex.sum.where.extend(embedded_position(model, positions, held.vertex));
  if (depth <= of_hex.deepest) return;
  of_hex.deepest = depth;
  of_hex.contact = make_surface_contact(model, vertex, held.vertex.hex, held.other.hex);
}

PartPlace place_of(const ContactStep& step, int hex) {
  const VertexClusters& clusters = step.geometry->clusters;
  const Model::BodyRange& body = body_of(*step.model, hex);
  const Matrix8x3d nodes = hex_nodes(*step.model, step.positions_t0, hex);
  PartPlace place;
  for (int c = clusters.hex_starts[hex]; c < clusters.hex_starts[hex + 1]; ++c)
    for (int k = 0; k < clusters.all[std::size_t(c)].count; ++k) {
      const int vertex = clusters.points[std::size_t(clusters.all[std::size_t(c)].first + k)];
      place.sum += nodes.transpose() * surface_weights(body, vertex);
      ++place.vertices;
    }
  return place;
}

void add_hex(const WaySum& hex, const PartPlace& place, bool is_first, WaySum& sum) {
  sum.ways += is_first ? hex.ways : Vector3d(-hex.ways);
  sum.axes += hex.axes;
  sum.depths += hex.depths;
  sum.where.extend(hex.where);
  PartPlace& part = is_first ? sum.first : sum.second;
  part.sum += place.sum;
  part.vertices += place.vertices;
}

// The way of the first body that most of the vertices have in common. Where each has its own, as in limbs that cross in
// each other's middle: across the surfaces of both, to the side where the first is already.
Vector3d direction_of(const WaySum& sum) {
  if (sum.ways.norm() > one_way * sum.depths) return sum.ways.normalized();
  const Vector3d across = Eigen::SelfAdjointEigenSolver<Matrix3d>(sum.axes).eigenvectors().col(2);
  const bool are_both_known = sum.first.vertices > 0 && sum.second.vertices > 0;
  const Vector3d from_second = are_both_known ? Vector3d(sum.first.mean() - sum.second.mean()) : sum.ways;
  return from_second.dot(across) < 0 ? Vector3d(-across) : across;
}

}  // namespace

std::vector<Overlap> find_overlaps(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  if (!geometry.touchable.any()) return {};
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  const std::vector<Encounter>& encounters = search.clearances.encounters.all;
  std::vector<Overlap> of_encounters(encounters.size());
  visit_inside(search, [&](std::size_t i, int, const HeldVertex&, const Touch& touch) {
    ++of_encounters[i].vertices;
    of_encounters[i].depth = std::max(of_encounters[i].depth, -touch.gap);
  });
  std::map<std::pair<int, int>, Overlap> sums;
  for (std::size_t i = 0; i < encounters.size(); ++i) {
    if (of_encounters[i].vertices == 0) continue;
    const int a = model.hex_body[encounters[i].hex], b = encounters[i].body;
    Overlap& sum = sums.try_emplace({a, b}, Overlap{a, b}).first->second;
    sum.vertices += of_encounters[i].vertices;
    sum.depth = std::max(sum.depth, of_encounters[i].depth);
  }
  std::vector<Overlap> overlaps;
  for (const auto& [bodies, sum] : sums) overlaps.push_back(sum);
  return overlaps;
}

VectorXd overlap_depths(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  VectorXd depths = VectorXd::Zero(model.num_points());
  if (!geometry.touchable.any()) return depths;
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  std::vector<std::vector<std::pair<int, double>>> of_encounters(search.clearances.encounters.all.size());
  visit_inside(search, [&](std::size_t i, int vertex, const HeldVertex&, const Touch& touch) {
    of_encounters[i].emplace_back(vertex, -touch.gap);
  });
  for (const auto& vertices : of_encounters)
    for (const auto& [vertex, depth] : vertices) depths[vertex] = std::max(depths[vertex], depth);
  return depths;
}

double max_surface_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions,
                               std::shared_ptr<Clearances> known) {
  if (!geometry.touchable.any()) return 0;
  const ContactStep step = at_rest(model, geometry, positions, std::move(known));
  const Search search = search_at(step, positions);
  const LastApart apart(positions);
  VectorXd depths = VectorXd::Zero(Eigen::Index(search.clearances.encounters.all.size()));
  for_each_encounter(search, [&](std::size_t i, const Encounter&) {
    depths[Eigen::Index(i)] = -find_deepest(meet(search, apart, i), 0, [](const HeldVertex&) { return 0.0; }).gap;
  });
  return depths.size() ? depths.maxCoeff() : 0;
}

bool are_deep(const ContactStep& step, const std::vector<Contact>& contacts) {
  const Model& model = *step.model;
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    HeldVertex held;
    const Vector3d position = embedded_position(model, step.positions_t0, contact.support);
    return contact.between_bodies() &&
           hold(model, step.positions_t0, contact.support, position,
                hex_maps(model, step.positions_t0, contact.other.hex), around_hex, held) &&
           measure(model, held, {}).gap < -nearly_outside * tolerance_depth(model, contact);
  });
}

DeepStart find_deep_start(const ContactStep& step) {
  const Model& model = *step.model;
  const ContactStep rest = at_rest(model, *step.geometry, step.positions_t0);
  const Search search = search_at(rest, step.positions_t0);
  const std::vector<Encounter>& encounters = search.clearances.encounters.all;
  std::vector<HexWays> of_encounters(encounters.size());
  visit_inside(search, [&](std::size_t i, int vertex, const HeldVertex& held, const Touch& touch) {
    const Encounter& encounter = encounters[i];
    if (model.hex_body[encounter.hex] == encounter.body) return;
    const double tolerance = tolerance_between(model, encounter.hex, encounter.others.front());
    if (touch.gap < -nearly_outside * tolerance)
      add_vertex(model, step.positions_t0, vertex, held, touch, of_encounters[i]);
  });
  DeepStart found;
  std::map<std::pair<int, int>, WaySum> sums;
  for (std::size_t i = 0; i < encounters.size(); ++i) {
    if (of_encounters[i].deepest == 0) continue;
    const int body = model.hex_body[encounters[i].hex], other = encounters[i].body;
    add_hex(of_encounters[i].sum, place_of(step, encounters[i].hex), body < other, sums[std::minmax(body, other)]);
    found.contacts.push_back(of_encounters[i].contact);
  }
  for (const auto& [bodies, sum] : sums) {
    const auto [first, second] = bodies;
    const double around = rim * std::min(model.bodies[first].cell_size, model.bodies[second].cell_size);
    const Eigen::AlignedBox3d where(sum.where.min().array() - around, sum.where.max().array() + around);
    const Vector3d direction = direction_of(sum);
    found.ways_out[{first, second}] = {direction, where};
    found.ways_out[{second, first}] = {-direction, where};
  }
  return found;
}

}  // namespace umax
