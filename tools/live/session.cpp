#include "tools/live/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/files/sha256.h"
#include "tools/pictures/heat.h"
#include "tools/setup/body_contact.h"
#include "tools/system/seconds_since.h"

namespace umax {
namespace {

constexpr double pull_frequency = 4;  // [Hz] of the body's whole mass on the spring
constexpr double fastest_handle = 2;  // [m/s] of what is moved by hand
constexpr double most_pull = 8;       // [-] of the body's weight on earth

double time_of_change(const Session& session) {
  return (double(session.state.step) + 0.25) * session.simulation.options.time_step;
}

double time_after(const Session& session) {
  return double(session.state.step + 1) * session.simulation.options.time_step;
}

void hold_now(Session& session, std::size_t key, double value) {
  if (value == value_now(session, key)) return;
  hold_from(session.keys[key], time_of_change(session), value, session.simulation);
  forget_model(session.stepping);
}

// [-] of any hex of a body: a limit that was none has nowhere to fall from but there
double largest_stretch(const Session& session, int body) {
  const Model::BodyRange& range = session.simulation.model.bodies[std::size_t(body)];
  return heat_values(session.simulation, session.state, Heatmap::stretch)
             .segment(range.first_hex, range.num_hexes)
             .maxCoeff() /
         100;
}

void lead_limits(Session& session) {
  const double h = session.simulation.options.time_step;
  for (std::size_t i = 0; i < session.keys.size(); ++i) {
    const double now = value_now(session, i);
    if (session.keys[i].kind != LiveKind::limit || session.goals[i] == now) continue;
    hold_now(session, i,
             limit_after_step(session.keys[i], session.simulation, now, session.goals[i], time_after(session), h));
  }
}

void lead_handles(Session& session) {
  const double farthest = fastest_handle * session.simulation.options.time_step;
  for (std::size_t i = 0; i < session.places.size(); ++i) {
    if (!session.places[i]) continue;
    const Vector3d now = place_at(session.simulation, i, time_after(session));
    const Vector3d way = *session.places[i] - now;
    const bool is_there = way.norm() <= farthest;
    place_from(i, time_of_change(session),
               is_there ? *session.places[i] : Vector3d(now + way * (farthest / way.norm())), session.simulation);
    if (is_there) session.places[i].reset();
    forget_model(session.stepping);
  }
}

Vector3d place_of(const Session& session, const Pull& pull, const Model::BodyRange& body) {
  return hex_nodes(session.simulation.model, session.state.positions, body.first_hex + pull.hex).transpose() *
         pull.weights;
}

// the spring of a grab: as stiff as lets the whole body swing on it slowly, and no longer than its force may be
Pull pull_of(const Session& session, const Grab& grab) {
  const Model& model = session.simulation.model;
  const BodySetup& setup = session.simulation.bodies[std::size_t(grab.body)];
  const Model::BodyRange& body = model.bodies[std::size_t(grab.body)];
  const double turns = 2 * std::numbers::pi * pull_frequency;
  const double mass = model.node_mass.segment(body.first_node, body.num_nodes).sum();
  Pull pull{.body = body.name, .hex = setup.embedding->hex[grab.vertex]};
  const Vector3d local = 2 * setup.embedding->local.row(grab.vertex).transpose().array() - 1;
  pull.weights = shape_functions(local);
  pull.stiffness = mass * turns * turns;
  const Vector3d from = place_of(session, pull, body);
  const double longest = most_pull * 9.81 / (turns * turns), wanted = (grab.goal - from).norm();
  pull.place = wanted > longest ? Vector3d(from + (grab.goal - from) * (longest / wanted)) : grab.goal;
  return pull;
}

// what a session asks of a simulation
void require_live(const Simulation& simulation) {
  if (!simulation.scene.clip.allow_overlap) require_clear_start(simulation.model);
}

}  // namespace

Session::Session(const Scene& scene) : simulation(set_up(with_turnable_limits(scene))), original(simulation.scene) {
  require_live(simulation);
  if (original.clip.preroll > 0)
    throw Error(Fault::bad_data, {.where = "clip.preroll",
                                  .what = "leads bodies before the first frame, which a live session does not",
                                  .value = fmt::format("{} s", original.clip.preroll),
                                  .remedy = "give --set clip.preroll=0, or run the scene with umax simulate"});
  if (simulation.bodies.empty())
    throw Error(Fault::bad_data,
                {.where = original.name, .what = "has no body", .remedy = "add [body.NAME] to the scene"});
  if (!simulation.pulls.empty())
    throw Error(Fault::bad_data, {.where = "clip.pulls",
                                  .what = "says how bodies were pulled before, which a live session would overwrite",
                                  .remedy = "give the scene of that session, or run this one with umax simulate"});
  keys = live_keys(original);
  for (std::size_t i = 0; i < keys.size(); ++i) goals.push_back(keys[i].value_at(original, 0));
  places.resize(count_handles(original));
  cells.resize(original.bodies.size());
  stepping = begin_stepping_in_place(simulation);
  state = rest_state(simulation.model);
  last = measure(simulation.model, simulation.options, state);
}

double value_now(const Session& session, std::size_t key) {
  return session.keys[key].value_at(session.simulation.scene, time_after(session));
}

bool set_key(Session& session, std::size_t key, double value) {
  if (key >= session.keys.size()) return false;
  const LiveKey& of = session.keys[key];
  if (of.is_animated || !(value >= of.least && value <= of.most)) return false;
  session.goals[key] = value;
  if (of.may_be_none && value < no_limit && value_now(session, key) >= no_limit && session.state.step > 0)
    hold_now(session, key, std::clamp(1.05 * largest_stretch(session, of.body), value, no_limit));
  // nothing is strained before the first step, and what does not fall throws nothing
  if (of.kind != LiveKind::limit || value >= value_now(session, key) || session.state.step == 0)
    hold_now(session, key, value);
  return true;
}

bool can_grab(const Session& session) {
  const SolverOptions& solver = session.simulation.options.solver;
  return solver.method == SolverMethod::exact && solver.linear != LinearSolver::multigrid;
}

bool grab(Session& session, const Grab& grab) {
  const auto& bodies = session.simulation.bodies;
  if (grab.body < 0 || grab.body >= int(bodies.size()) || grab.vertex < 0 ||
      grab.vertex >= bodies[std::size_t(grab.body)].embedding->hex.size() || !grab.goal.allFinite() ||
      grab.goal.norm() > 1e6)
    return false;
  if (!can_grab(session)) return false;
  session.grab = grab;
  return true;
}

void release(Session& session) {
  session.grab.reset();
}

bool place_handle(Session& session, std::size_t handle, const Vector3d& place) {
  if (handle >= session.places.size() || !can_place(session.original, handle) || !place.allFinite() ||
      place.norm() > 1e6)
    return false;
  session.places[handle] = place;
  return true;
}

const StepReport& step(Session& session) {
  lead_limits(session);
  lead_handles(session);
  std::vector<Pull> pulls;
  if (session.grab) {
    pulls.push_back(pull_of(session, *session.grab));
    session.pulls[session.state.step] = pulls;
  }
  const auto begin = std::chrono::steady_clock::now();
  session.last = advance(session.stepping, pulls, session.state);
  if (!session.state.positions.allFinite())
    throw Error(Fault::internal, {.where = fmt::format("step {}", session.state.step),
                                  .what = "positions are no longer finite",
                                  .remedy = "please report it with the saved session"});
  session.steps_not_converged += session.last.status != StepStatus::converged;
  session.rows.push_back({.step = session.state.step,
                          .frame = session.frame(),
                          .time = session.state.time,
                          .hexes = session.simulation.model.num_hexes(),
                          .report = session.last,
                          .wall_ms = 1000 * seconds_since(begin),
                          .probes = probe_positions(session.simulation, session.state.positions)});
  if (session.rows.size() > session.most_rows) session.rows.pop_front();
  return session.last;
}

void restart(Session& session) {
  rewind(session, rest_state(session.simulation.model));
}

bool can_set_cells(const Session& session, int body) {
  if (body < 0 || body >= int(session.original.bodies.size())) return false;
  const BodyDescription& description = session.original.bodies[std::size_t(body)];
  return !description.brings_its_hexes() && !std::holds_alternative<MeshSource>(description.cage.size);
}

bool set_cells(Session& session, int body, int cells) {
  if (!can_set_cells(session, body) || cells < 1 || cells > most_live_cells) return false;
  Scene scene = session.original;
  scene.bodies[std::size_t(body)].cage.size = cells;
  Simulation made = set_up(scene);
  require_live(made);
  const auto on_iteration = session.stepping.options.on_iteration;
  {
    const std::lock_guard lock(session.other_meshes);
    session.simulation = std::move(made);
  }
  session.original = session.simulation.scene;
  session.keys = live_keys(session.original);
  session.stepping = begin_stepping_in_place(session.simulation);
  session.stepping.options.on_iteration = on_iteration;
  session.cells[std::size_t(body)] = cells;
  release(session);
  restart(session);
  return true;
}

void rewind(Session& session, const State& state) {
  const std::vector<double> values = session.goals;
  session.state = state;
  session.pulls.erase(session.pulls.lower_bound(state.step), session.pulls.end());
  // rows that are no longer kept count all the same
  for (; !session.rows.empty() && session.rows.back().step > state.step; session.rows.pop_back())
    session.steps_not_converged -= session.rows.back().report.status != StepStatus::converged;
  if (state.step == 0) session.steps_not_converged = 0;
  for (const LiveKey& key : session.keys) drop_from(key, time_of_change(session), session.simulation);
  drop_places_from(session.original, time_of_change(session), session.simulation);
  session.places.assign(session.places.size(), std::nullopt);
  session.stepping.workspace.reset();
  bring_to(session.simulation.model, state.time);
  if (state.step == 0) session.state = rest_state(session.simulation.model);
  for (std::size_t i = 0; i < session.keys.size(); ++i)
    if (!session.keys[i].is_animated) set_key(session, i, values[i]);
  session.last = session.rows.empty() ? measure(session.simulation.model, session.simulation.options, session.state)
                                      : session.rows.back().report;
}

SessionFiles session_files(const Session& session, const std::string& pulls_name) {
  SessionFiles files{session.simulation.scene, {}};
  ClipDescription& clip = files.scene.clip;
  clip.frames = std::max(1, int(session.state.step / session.substeps()) + 1);
  if (!session.pulls.empty()) {
    files.pulls = encode_pulls(session.pulls, session.simulation.model);
    clip.pulls = pulls_name;
    clip.pulls_sha256 = sha256_hex(files.pulls);
  }
  return files;
}

std::string scene_lines(const Session& session) {
  std::string lines;
  for (std::size_t b = 0; b < session.cells.size(); ++b)
    if (session.cells[b])
      lines += fmt::format("body.{}.cage.cells = {}\n", session.original.bodies[b].name, *session.cells[b]);
  for (std::size_t i = 0; i < session.keys.size(); ++i) {
    const LiveKey& key = session.keys[i];
    if (key.is_animated || session.goals[i] == key.value_at(session.original, 0)) continue;
    const double value = session.goals[i];
    if (key.kind == LiveKind::gravity) {
      const Vector3d g = value * key.direction;
      lines += fmt::format("{} = [{}, {}, {}]\n", key.path, g.x(), g.y(), g.z());
    } else {
      lines += fmt::format("{} = {}\n", key.path, value);
    }
  }
  return lines;
}

}  // namespace umax
