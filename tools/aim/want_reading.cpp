#include "tools/aim/want_reading.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "tools/pictures/heat.h"
#include "tools/pictures/shot.h"
#include "tools/run/run_folder.h"

namespace umax {
namespace {

constexpr double rest_speed = 0.01;  // [1/s] root mean square, of the body's largest length
constexpr double rounding = 1e-6;    // [frames]

Vector3d placed_size(const Simulation& simulation, std::size_t body) {
  return box_of(simulation.bodies[body], simulation.model.rest_positions).sizes();
}

/// [-] height over width and depth, as shares of those at the start.
double squash_of(const Vector3d& now, const Vector3d& placed) {
  const Vector3d share = now.cwiseQuotient(placed);
  return share.y() / std::sqrt(share.x() * share.z());
}

double largest_stretch(const Want& want, const Simulation& simulation, const State& state) {
  const Model::BodyRange& body = simulation.model.bodies[want.object];
  return heat_values(simulation, state, Heatmap::stretch).segment(body.first_hex, body.num_hexes).maxCoeff() / 100;
}

/// At one instant, in metres or as a ratio.
double value_now(const Want& want, const Simulation& simulation, const State& state) {
  if (want.measure == MeasureKind::tip) return probe_positions(simulation, state.positions)[want.object][want.axis];
  if (want.measure == MeasureKind::stretch) return largest_stretch(want, simulation, state);
  const Vector3d now = box_of(simulation.bodies[want.object], state.positions).sizes();
  switch (want.measure) {
    case MeasureKind::squash:
      return squash_of(now, placed_size(simulation, want.object));
    case MeasureKind::width:
      return now.x();
    case MeasureKind::length:
      return now[want.axis];
    default:
      return now.y();
  }
}

/// Between two frames: on the straight line.
Reading at_instant(const Want& want, const Simulation& simulation, const StateSource& states) {
  const double place = want.from * simulation.scene.clip.fps;
  const int before = int(std::floor(place + rounding));
  const double share = place - before;
  const double first = value_now(want, simulation, states(before + 1));
  if (share <= rounding) return {.value = first, .frame = before + 1};
  const double second = value_now(want, simulation, states(before + 2));
  return {.value = first + share * (second - first), .frame = before + (share < 0.5 ? 1 : 2)};
}

Reading over_span(const Want& want, const Simulation& simulation, const StateSource& states) {
  const double fps = simulation.scene.clip.fps;
  const int first = int(std::ceil(want.from * fps - rounding)) + 1,
            last = int(std::floor(want.to * fps + rounding)) + 1;
  Reading found;
  for (int frame = first; frame <= last; ++frame) {
    const double value = value_now(want, simulation, states(frame));
    const bool better = want.moment == WantMoment::least ? value < found.value : value > found.value;
    if (frame == first || better) found.value = value, found.frame = frame;
  }
  return found;
}

/// [m/s] root mean square of a body.
double speed_of(const Model& model, const Model::BodyRange& body, const State& state) {
  const auto mass = model.node_mass.segment(body.first_node, body.num_nodes);
  const auto velocities = state.velocities.middleRows(body.first_node, body.num_nodes);
  return std::sqrt(mass.dot(velocities.rowwise().squaredNorm()) / mass.sum());
}

/// From the last frame that is too fast on, where the logarithm of the speed, between two frames on a straight line,
/// gets small enough.
Reading time_of_rest(const Want& want, const Simulation& simulation, const StateSource& states) {
  const double limit = rest_speed * placed_size(simulation, want.object).maxCoeff();
  const double fps = simulation.scene.clip.fps;
  double after = 0;
  for (int frame = simulation.last_frame(); frame >= 1; --frame) {
    const double speed = speed_of(simulation.model, simulation.model.bodies[want.object], states(frame));
    if (speed > limit && frame == simulation.last_frame())
      return {.value = std::numeric_limits<double>::infinity(), .frame = frame};
    if (speed > limit) {
      const double share = std::log(speed / limit) / std::log(speed / std::max(after, 1e-9 * limit));
      return {.value = (frame - 1 + share) / fps, .frame = frame + 1};
    }
    after = speed;
  }
  return {.value = 0, .frame = 1};
}

/// [m] of the surface's lowest point, in every frame.
std::vector<double> lowest_points(const Want& want, const Simulation& simulation, const StateSource& states) {
  std::vector<double> lowest;
  for (int frame = 1; frame <= simulation.last_frame(); ++frame)
    lowest.push_back(box_of(simulation.bodies[want.object], states(frame).positions).min().y());
  return lowest;
}

Reading bounce_of(const Want& want, const Simulation& simulation, const StateSource& states) {
  const std::vector<double> lowest = lowest_points(want, simulation, states);
  // the first impact: where it stops falling
  std::size_t impact = 1;
  while (impact < lowest.size() && lowest[impact] >= lowest[impact - 1]) ++impact;
  while (impact + 1 < lowest.size() && lowest[impact + 1] < lowest[impact]) ++impact;
  if (impact + 1 >= lowest.size())
    throw Error(Fault::bad_data,
                {.where = "--want " + want.text,
                 .what = "the body does not land within the clip",
                 .value = std::to_string(lowest.size()) + " frames",
                 .remedy = "give it more, as by --set clip.frames=" + std::to_string(2 * lowest.size())});
  const auto begin = lowest.begin(), at = begin + std::ptrdiff_t(impact);
  const auto top = std::max_element(at, lowest.end());
  const double fall = *std::max_element(begin, at) - *at;
  return {.value = (*top - *at) / (want.is_share ? fall : 1), .frame = int(top - begin) + 1};
}

double scale_of(const Want& want, const Simulation& simulation) {
  if (want.measure != MeasureKind::tip) return want.value;
  const ProbeDescription& probe = simulation.scene.probes[want.object];
  double size = 1;
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i)
    if (simulation.bodies[i].name == probe.body) size = placed_size(simulation, i).maxCoeff();
  const double start = probe_positions(simulation, simulation.model.rest_positions)[want.object][want.axis];
  return std::max(std::abs(want.value - start), size / 10);
}

}  // namespace

Reading read_want(const Want& want, const Simulation& simulation, const StateSource& states) {
  Reading reading;
  if (want.measure == MeasureKind::rest)
    reading = time_of_rest(want, simulation, states);
  else if (want.measure == MeasureKind::bounce)
    reading = bounce_of(want, simulation, states);
  else if (want.moment == WantMoment::instant)
    reading = at_instant(want, simulation, states);
  else
    reading = over_span(want, simulation, states);
  const bool of_placed = want.is_share && want.measure != MeasureKind::bounce;
  const int axis = want.measure == MeasureKind::width ? 0 : want.measure == MeasureKind::length ? want.axis : 1;
  if (of_placed) reading.value /= placed_size(simulation, want.object)[axis];
  reading.scale = scale_of(want, simulation);
  return reading;
}

StateSource states_of_run(const Simulation& simulation, const std::filesystem::path& run) {
  return
      [&simulation, run](int frame) { return read_state(state_path(run, frame), simulation.model, simulation.digest); };
}

double miss_of(const Want& want, const Reading& reading) {
  constexpr double most = 10;
  return std::clamp((reading.value - want.value) / reading.scale, -most, most);
}

}  // namespace umax
