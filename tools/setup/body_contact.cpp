#include "tools/setup/body_contact.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/step/step.h"

namespace umax {
namespace {

// "body.a is an open mesh", "body.a, body.b, body.c, body.d, body.e and 25 more are open meshes"
std::string open_meshes(const Model& model, const std::vector<int>& bodies) {
  constexpr std::size_t most_names = 5;
  const std::size_t shown = bodies.size() > most_names + 1 ? most_names : bodies.size();
  std::string text;
  for (std::size_t i = 0; i < shown; ++i)
    text += (i == 0 ? "" : i + 1 == bodies.size() ? " and " : ", ") + ("body." + model.bodies[bodies[i]].name);
  if (shown < bodies.size()) text += fmt::format(" and {} more", bodies.size() - shown);
  return text + (bodies.size() == 1 ? " is an open mesh" : " are open meshes");
}

constexpr double deep_share = 0.05;  // of a body's vertices, more than which are no touch any more

std::string text_of(const Model& model, const Overlap& overlap) {
  return fmt::format("starts {:.4g} m deep inside {}, with {} of its {} surface points", overlap.depth,
                     overlap.a == overlap.b ? "itself" : "body." + model.bodies[overlap.b].name, overlap.vertices,
                     model.bodies[overlap.a].num_points);
}

}  // namespace

std::vector<BodyPair> make_pairs(const Scene& scene) {
  const auto index_of = [&](const std::string& name) {
    const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                   [&](const BodyDescription& description) { return description.name == name; });
    return int(body - scene.bodies.begin());
  };
  std::vector<BodyPair> pairs;
  for (const PairDescription& pair : scene.pairs)
    pairs.push_back({index_of(pair.bodies[0]), index_of(pair.bodies[1]), pair.touch, pair.friction});
  return pairs;
}

std::vector<char> touched_bodies(const Scene& scene) {
  Model model;  // of what touches what, and nothing else
  for (const BodyDescription& body : scene.bodies) model.bodies.emplace_back().contact = body.contact;
  model.pairs = make_pairs(scene);
  const auto num_bodies = int(model.bodies.size());
  std::vector<char> is_touched(model.bodies.size(), 0);
  for (int a = 0; a < num_bodies; ++a)
    for (int b = a; b < num_bodies; ++b)
      if (may_touch(model, a, b)) is_touched[a] = is_touched[b] = 1;
  return is_touched;
}

void warn_of_open_meshes(const Model& model, std::vector<std::string>& warnings) {
  const auto num_bodies = int(model.bodies.size());
  const auto is_open = [&](int body) { return !model.bodies[body].rest_surface; };
  std::vector<int> by_points, through_each_other, through_itself;
  for (int a = 0; a < num_bodies; ++a) {
    if (!is_open(a)) continue;
    bool touches_closed = false, meets_open = false;
    for (int b = 0; b < num_bodies; ++b)
      if (b != a && may_touch(model, a, b)) (is_open(b) ? meets_open : touches_closed) = true;
    if (touches_closed) by_points.push_back(a);
    if (meets_open) through_each_other.push_back(a);
    if (may_touch(model, a, a)) through_itself.push_back(a);
  }
  const auto warn = [&](const std::vector<int>& bodies, const char* of_one, const char* of_many) {
    if (!bodies.empty())
      warnings.push_back(open_meshes(model, bodies) + ": " + (bodies.size() == 1 ? of_one : of_many));
  };
  warn(by_points, "it touches other bodies by its vertices, and others pass through it",
       "they touch other bodies by their vertices, and others pass through them");
  warn(through_each_other, "", "they pass through each other");
  warn(through_itself, "its parts pass through each other; close it, or write contact = \"others\"",
       "their own parts pass through each other; close them, or write contact = \"others\"");
}

void warn_of_paper_method(const Model& model, SolverMethod method, std::vector<std::string>& warnings) {
  if (method != SolverMethod::paper) return;
  for (int a = 0; a < int(model.bodies.size()); ++a)
    for (int b = 0; b < a; ++b)
      if (may_touch(model, a, b)) {
        warnings.push_back(
            "solver.method \"paper\" knows obstacles alone: bodies pass through each other and themselves");
        return;
      }
}

void warn_of_overlaps(const Model& model, std::vector<std::string>& warnings) {
  for (const Overlap& overlap : find_overlaps(model, rest_state(model)))
    warnings.push_back(fmt::format("body.{} {}; they will be pushed apart slowly; move one of them to avoid it",
                                   model.bodies[overlap.a].name, text_of(model, overlap)));
}

void require_clear_start(const Model& model) {
  for (const Overlap& overlap : find_overlaps(model, rest_state(model))) {
    const Model::BodyRange &body = model.bodies[overlap.a], &other = model.bodies[overlap.b];
    if (overlap.depth <= std::min(body.cell_size, other.cell_size) && overlap.vertices <= deep_share * body.num_points)
      continue;
    throw Error(Fault::bad_data,
                {.where = "body." + body.name + ".position",
                 .what = text_of(model, overlap),
                 .remedy = "move one of them, let them not touch (contact, [pair]), or start so with --allow-overlap"});
  }
}

}  // namespace umax
