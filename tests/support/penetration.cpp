#include "tests/support/penetration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "core/base/parallel.h"
#include "tests/support/hex_hulls.h"

namespace umax::test {
namespace {

constexpr int task_triangles = 4096;  // at most, of a task

// what points are held against: another body, or the far part of their own
struct Target {
  int body = 0;
  SurfaceView now;
  std::optional<SurfaceView> rest;  // of their own
};

// a body in the state that is measured
struct Deformed {
  TreeShape shape;
  // to tell which points may lie in a far part
  std::vector<HexHull> hulls;
  std::vector<std::vector<int>> close;  // hexes by hex
  double margin = 0;                    // [m] by which a far part may stand out of its hexes
};

struct Scene {
  const Model& model;
  const std::vector<MeasuredBody>& bodies;
  std::vector<Deformed> deformed;
};

// a part of body `a` against body `b`; indices into Scene::bodies
struct Task {
  int a = 0, b = 0;
  int part = 0;  // a node of a's tree; with a == b one of its places
};

// how deep a point lies in the target [m], now and at rest; nothing outside of it
std::optional<double> depth_in(const Target& target, const Vector3d& now, const Vector3d& rest) {
  double winding = winding_number(target.now, now);
  if (target.rest) winding -= winding_number(*target.rest, rest);
  if (winding <= 0.5) return {};
  return distance(target.now, now);
}

void keep_deeper(const Penetration& found, Penetration& deepest) {
  if (found.cells > deepest.cells) deepest = found;
}

// the points and edges of one body against one target
struct Measurement {
  const Scene& scene;
  int source;  // index into the scene's bodies
  Target target;
  PenetrationReport& report;

  const MeasuredBody& body() const { return scene.bodies[source]; }
  const Points& positions() const { return scene.deformed[source].shape.positions; }

  Penetration penetration(double depth, const Vector3d& place) const {
    const int a = body().body, b = target.body;
    const double cell = std::min(scene.model.bodies[a].cell_size, scene.model.bodies[b].cell_size);
    return {.cells = depth / cell, .depth = depth, .body = a, .other = b, .place = place};
  }

  void measure_point(int index) {
    const SurfacePoint& point = body().points[index];
    const Vector3d now = point_at(point, positions());
    const auto depth = depth_in(target, now, point_at(point, body().rest.positions));
    if (!depth) return;
    ++report.points_inside;
    keep_deeper(penetration(*depth, now), target.rest ? report.within : report.between);
  }

  void measure_edge(int index) {
    const auto& [a, b] = body().edges[index];
    const Vector3d p = positions().row(a).transpose(), q = positions().row(b).transpose();
    std::vector<double> cuts;
    for (const int t : triangles_in(target.now, Box(p.cwiseMin(q), p.cwiseMax(q))))
      if (const auto cut = crossing(p, q, triangle_at(target.now, t))) cuts.push_back(*cut);
    if (cuts.empty()) return;
    std::sort(cuts.begin(), cuts.end());
    std::vector<double> shares{0, 0.5 * cuts.front(), 0.5 * (cuts.back() + 1), 1};
    for (std::size_t i = 1; i < cuts.size(); ++i) shares.push_back(0.5 * (cuts[i - 1] + cuts[i]));
    int inside = 0;
    for (const double share : shares) inside += measure_on_edge(index, share);
    report.edges_crossing += inside > 0;
  }

  // whether that place of the edge is inside
  bool measure_on_edge(int index, double share) {
    const auto at = [&](const Points& points) -> Vector3d {
      const auto& [a, b] = body().edges[index];
      return ((1 - share) * points.row(a) + share * points.row(b)).transpose();
    };
    const Vector3d now = at(positions());
    const auto depth = depth_in(target, now, at(body().rest.positions));
    if (depth) keep_deeper(penetration(*depth, now), report.crossing);
    return depth.has_value();
  }

  // the points and edges below a node of the body's tree
  void measure_node(int index) {
    const SurfaceTree::Node& node = body().tree.nodes[index];
    const Box& box = scene.deformed[source].shape.nodes[index].box;
    if (!box.intersects(target.now.shape.nodes[0].box)) return;
    if (!has_triangles_in(target.now, box)) {  // all inside or all outside
      if (winding_number(target.now, box.center()) > 0.5) measure_inside(index);
      return;
    }
    if (!node.is_leaf()) {
      measure_node(index + 1);
      measure_node(node.right);
      return;
    }
    for (int p = body().point_starts[node.begin]; p < body().point_starts[node.end]; ++p) measure_point(p);
    for (int e = body().edge_starts[node.begin]; e < body().edge_starts[node.end]; ++e) measure_edge(e);
  }

  // the points below a node all of which lie inside the other body
  void measure_inside(int index) {
    const SurfaceTree::Node& node = body().tree.nodes[index];
    const Box& box = scene.deformed[source].shape.nodes[index].box;
    const int first = body().point_starts[node.begin], last = body().point_starts[node.end];
    const double most = distance(target.now, box.center()) + 0.5 * box.diagonal().norm();
    if (penetration(most, box.center()).cells <= report.between.cells) {  // none is deeper than what is known
      report.points_inside += last - first;
    } else if (!node.is_leaf()) {
      measure_inside(index + 1);
      measure_inside(node.right);
    } else {
      report.points_inside += last - first;
      for (int p = first; p < last; ++p) {
        const Vector3d place = point_at(body().points[p], positions());
        keep_deeper(penetration(distance(target.now, place), place), report.between);
      }
    }
  }
};

const Box& root_box(const Scene& scene, int body) {
  return scene.deformed[body].shape.nodes[0].box;
}

// nodes that hold all triangles together, each not too many for one task
void collect_parts(const SurfaceTree& tree, int node, std::vector<int>& parts) {
  const auto& [begin, end, right] = tree.nodes[node];
  if (end - begin <= task_triangles || right < 0) return parts.push_back(node);
  collect_parts(tree, node + 1, parts);
  collect_parts(tree, right, parts);
}

Deformed deform(const Model& model, const MeasuredBody& body, const Points& node_positions) {
  Deformed out;
  out.shape = shape_tree(body.tree, vertex_positions(model, body, node_positions));
  out.hulls = hex_hulls(model, body.body, node_positions);
  // A point of an edge is at most 1/2 of its length from a vertex, a point of a triangle 1/sqrt(3) of its longest edge.
  out.margin = (0.5 + 1 / std::sqrt(3.0)) * longest_edge(body, out.shape.positions);
  out.close = close_hexes(model, body.body, out.hulls, out.margin);
  return out;
}

// the hexes, within their body, that are close to one of the place's
std::vector<int> close_to(const Scene& scene, int body, const SamePlace& place) {
  const Model::BodyRange& range = scene.model.bodies[scene.bodies[body].body];
  std::vector<int> close;
  for (const int hex : place.hexes) {
    const std::vector<int>& more = scene.deformed[body].close[hex - range.first_hex];
    close.insert(close.end(), more.begin(), more.end());
  }
  return close;
}

// of the place's points and edges those that may lie in a far part, or cross it: a far part is within the hulls of its
// hexes, but for the margin
SamePlace in_far_parts(const Scene& scene, int index, const SamePlace& place) {
  const MeasuredBody& body = scene.bodies[index];
  const Deformed& deformed = scene.deformed[index];
  const std::vector<int> close = close_to(scene, index, place);
  const auto is_held = [&](const Vector3d& x) {
    return std::any_of(close.begin(), close.end(),
                       [&](int hex) { return may_hold(deformed.hulls[hex], x, deformed.margin); });
  };
  SamePlace held{place.hexes, {}, {}};
  const Points& positions = deformed.shape.positions;
  for (const int p : place.points)
    if (is_held(point_at(body.points[p], positions))) held.points.push_back(p);
  for (const int e : place.edges)
    if (is_held(positions.row(body.edges[e][0]).transpose()) || is_held(positions.row(body.edges[e][1]).transpose()))
      held.edges.push_back(e);
  return held;
}

std::vector<int> parts_against(const Scene& scene, int a, int b) {
  std::vector<int> parts;
  const auto& [body, other] = std::tie(scene.bodies[a], scene.bodies[b]);
  if (!may_touch(scene.model, body.body, other.body)) return parts;
  if (a != b) {
    if (root_box(scene, a).intersects(root_box(scene, b))) collect_parts(body.tree, 0, parts);
    return parts;
  }
  for (std::size_t i = 0; i < body.places.size(); ++i)
    if (!close_to(scene, a, body.places[i]).empty()) parts.push_back(int(i));
  return parts;
}

LeftOut near_triangles(const Scene& scene, const MeasuredBody& body, const SamePlace& place) {
  std::vector<int> triangles;
  for (const int hex : hexes_around(scene.model, {place.hexes.begin(), place.hexes.end()})) {
    const auto& more = body.hex_triangles[hex - scene.model.bodies[body.body].first_hex];
    triangles.insert(triangles.end(), more.begin(), more.end());
  }
  return leave_out(body.tree, triangles);
}

void run(const Scene& scene, const Task& task, PenetrationReport& report) {
  const MeasuredBody& other = scene.bodies[task.b];
  if (task.a != task.b) {
    Measurement{scene, task.a, {other.body, {other.tree, scene.deformed[task.b].shape}, {}}, report}.measure_node(
        task.part);
    return;
  }
  const SamePlace place = in_far_parts(scene, task.a, other.places[task.part]);
  if (place.points.empty() && place.edges.empty()) return;
  const LeftOut near = near_triangles(scene, other, place);
  const SurfaceView now{other.tree, scene.deformed[task.a].shape, &near}, rest{other.tree, other.rest, &near};
  Measurement measurement{scene, task.a, {other.body, now, rest}, report};
  for (const int point : place.points) measurement.measure_point(point);
  for (const int edge : place.edges) measurement.measure_edge(edge);
}

}  // namespace

void add(const PenetrationReport& part, PenetrationReport& sum) {
  keep_deeper(part.between, sum.between);
  keep_deeper(part.within, sum.within);
  keep_deeper(part.crossing, sum.crossing);
  sum.points_inside += part.points_inside;
  sum.edges_crossing += part.edges_crossing;
}

PenetrationReport measure_penetration(const Model& model, const std::vector<MeasuredBody>& bodies,
                                      const Points& node_positions) {
  const Eigen::Index count = Eigen::Index(bodies.size());
  Scene scene{model, bodies, std::vector<Deformed>(bodies.size())};
  parallel_blocks(count, 1,
                  [&](Eigen::Index i, Eigen::Index) { scene.deformed[i] = deform(model, bodies[i], node_positions); });

  // find what is to be held against what: a row of tasks per body
  std::vector<std::vector<Task>> rows(bodies.size());
  parallel_blocks(count, 1, [&](Eigen::Index a, Eigen::Index) {
    for (int b = 0; b < int(count); ++b)
      for (const int part : parts_against(scene, int(a), b)) rows[a].push_back({int(a), b, part});
  });
  std::vector<Task> tasks;
  for (const std::vector<Task>& row : rows) tasks.insert(tasks.end(), row.begin(), row.end());

  std::vector<PenetrationReport> reports(tasks.size());
  parallel_blocks(Eigen::Index(tasks.size()), 1,
                  [&](Eigen::Index i, Eigen::Index) { run(scene, tasks[i], reports[i]); });
  PenetrationReport sum;
  for (const PenetrationReport& report : reports) add(report, sum);
  return sum;
}

}  // namespace umax::test
