#include "core/contact/surface_overlap.h"

#include <algorithm>

#include "core/contact/contact_support.h"
#include "core/contact/meeting.h"

namespace umax {
namespace {

constexpr double one_way = 0.3;  // [-] of the depths of vertices in a body, that their ways out have in common

// Calls visit(i, vertex, touch) for each vertex of encounter i that is inside a body, in parallel by encounter.
template <class Visit>
void visit_inside(const Search& search, const Visit& visit) {
  for_each_encounter(search, [&](std::size_t i, const Encounter&) {
    visit_held(meet(search, search.positions, i), [&](int vertex, const HeldVertex& held) {
      const Touch touch = measure(*search.step.model, held, nullptr);
      if (touch.gap < 0) visit(i, vertex, touch);
    });
  });
}

// ways out of a body, weighted by depth
struct WaySum {
  Vector3d ways = Vector3d::Zero();  // [m] depth by normal
  double depths = 0, deepest = 0;    // [m]
  void add(const WaySum& other, double sign) {
    ways += sign * other.ways;
    depths += other.depths;
    deepest = std::max(deepest, other.deepest);
  }
};

}  // namespace

std::vector<Overlap> find_overlaps(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  if (!geometry.touchable.any()) return {};
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  const std::vector<Encounter>& encounters = search.clearances.encounters.all;
  std::vector<Overlap> of_encounters(encounters.size());
  visit_inside(search, [&](std::size_t i, int, const Touch& touch) {
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
  VectorXd depths = VectorXd::Zero(model.surface.size());
  if (!geometry.touchable.any()) return depths;
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  std::vector<std::vector<std::pair<int, double>>> of_encounters(search.clearances.encounters.all.size());
  visit_inside(search, [&](std::size_t i, int vertex, const Touch& touch) {
    of_encounters[i].emplace_back(vertex, -touch.gap);
  });
  for (const auto& vertices : of_encounters)
    for (const auto& [vertex, depth] : vertices) depths[vertex] = std::max(depths[vertex], depth);
  return depths;
}

double max_surface_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions) {
  if (!geometry.touchable.any()) return 0;
  const ContactStep step = at_rest(model, geometry, positions);
  const Search search = search_at(step, positions);
  VectorXd depths = VectorXd::Zero(Eigen::Index(search.clearances.encounters.all.size()));
  for_each_encounter(search, [&](std::size_t i, const Encounter&) {
    depths[Eigen::Index(i)] = -find_deepest(meet(search, positions, i), 0, [](const HeldVertex&) { return 0.0; }).gap;
  });
  return depths.size() ? depths.maxCoeff() : 0;
}

bool are_deep(const ContactStep& step, const std::vector<Contact>& contacts) {
  const Model& model = *step.model;
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& contact) {
    HeldVertex held;
    const Vector3d position = embedded_position(model, step.positions_t0, contact.support);
    return contact.between_bodies() &&
           hold(model, step.positions_t0, step.positions_t0, contact.support, position, contact.other.hex, around_hex,
                held) &&
           measure(model, held, nullptr).gap < -nearly_outside * tolerance_depth(model, contact);
  });
}

std::map<std::pair<int, int>, WayOut> find_ways_out(const ContactStep& step) {
  const Model& model = *step.model;
  const ContactStep rest = at_rest(model, *step.geometry, step.positions_t0);
  const Search search = search_at(rest, step.positions_t0);
  const std::vector<Encounter>& encounters = search.clearances.encounters.all;
  std::vector<WaySum> of_encounters(encounters.size());
  visit_inside(search, [&](std::size_t i, int, const Touch& touch) {
    const Encounter& encounter = encounters[i];
    if (model.hex_body[encounter.hex] == encounter.body) return;
    const double tolerance = tolerance_between(model, encounter.hex, encounter.others.front());
    if (touch.gap < -nearly_outside * tolerance)
      of_encounters[i].add({-touch.gap * touch.normal, -touch.gap, -touch.gap}, 1);
  });
  std::map<std::pair<int, int>, WaySum> sums;  // the smaller body's way out of the other
  for (std::size_t i = 0; i < encounters.size(); ++i) {
    const int body = model.hex_body[encounters[i].hex], other = encounters[i].body;
    sums[std::minmax(body, other)].add(of_encounters[i], body < other ? 1 : -1);
  }
  std::map<std::pair<int, int>, WayOut> ways;
  for (const auto& [bodies, sum] : sums) {
    if (!(sum.ways.norm() > one_way * sum.depths)) continue;
    ways[bodies] = {sum.ways.normalized(), sum.deepest};
    ways[{bodies.second, bodies.first}] = {-sum.ways.normalized(), sum.deepest};
  }
  return ways;
}

}  // namespace umax
