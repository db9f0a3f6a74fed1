// Figures of contact between surfaces: what it costs a body that may touch itself, what the search alone costs, and how
// a heap comes to rest.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>
#include <vector>

#include "core/contact/clearances.h"
#include "core/contact/material_point.h"
#include "core/contact/surface_contact.h"
#include "scenes/scene_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/setup/simulation_setup.h"

namespace umax {
namespace {

double mean(const std::vector<double>& values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// mean times of steps [ms]
struct StepTimes {
  double active = 0, flight = 0;  // with a contact or an active limit, and without
};

StepTimes step_times(const std::string& scene, const std::vector<std::string>& settings) {
  std::vector<Override> overrides;
  for (const std::string& setting : settings) overrides.push_back(parse_override(setting));
  const Simulation simulation = set_up(load_scene(scene, overrides));
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  std::vector<double> active, flight;
  for (int frame = 1; frame < simulation.last_frame(); ++frame) {
    const auto start = std::chrono::steady_clock::now();
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    (report.contacts > 0 || report.limits_active > 0 ? active : flight).push_back(milliseconds_since(start));
  }
  return {mean(active), mean(flight)};
}

BenchRows self_contact(const std::string& body, const std::string& scene, std::vector<std::string> settings) {
  const auto times = [&](const std::string& contact) {
    std::vector<std::string> all = settings;
    all.push_back("body." + body + ".contact=" + contact);
    return step_times(scene, all);
  };
  const StepTimes obstacles = times("obstacles"), itself = times("all");
  const auto row = [&](const std::string& what, double with, double without, double limit) {
    return at_most(fmt::format("{}: {} step with self-contact over \"obstacles\"", body, what), with / without, limit,
                   "times", fmt::format("{:.2f} ms, {:.2f} ms", with, without));
  };
  return {row("active", itself.active, obstacles.active, 1.3), row("flight", itself.flight, obstacles.flight, 1.1)};
}

BenchRows armadillo_self_contact() {
  return self_contact("armadillo", "armadillo",
                      {"body.armadillo.mesh=" + model_path("armadillo.obj"), "clip.frames=250"});
}

// [-] of all surface points, those in a hex that another body, or a far part of the same, fills too
double share_near(const ContactStep& step, const Points& positions) {
  const Model& model = *step.model;
  std::vector<char> near(std::size_t(model.num_points()), 0);
  for (const Encounter& encounter : step.clearances->encounters.all)
    for (int k = step.geometry->hex_starts[encounter.hex]; k < step.geometry->hex_starts[encounter.hex + 1]; ++k) {
      const int point = step.geometry->hex_points[k];
      const Vector3d position = embedded_position(model, positions, {encounter.hex, surface_weights(model, point)});
      MaterialPoint material;
      near[std::size_t(point)] |= std::any_of(encounter.others.begin(), encounter.others.end(), [&](int other) {
        return find_material(hex_maps(model, positions, other), position, within_hex, material);
      });
    }
  return double(std::count(near.begin(), near.end(), 1)) / double(near.size());
}

// the search for contacts in the heap, as soon as a hundredth of all points are near others
BenchRows detection() {
  constexpr double wanted_share = 0.01;
  constexpr int frames_between = 5, repetitions = 20;
  const Simulation simulation = set_up(load_scene("heap"));
  const Model& model = simulation.model;
  const ContactGeometry geometry = make_contact_geometry(model);
  Workspace workspace(model);
  State state = rest_state(model);
  double share = 0;
  const auto begin = [&] {
    return begin_contact_step(model, geometry, state.positions, state.positions, state.time,
                              simulation.options.time_step, simulation.options.gravity.norm());
  };
  while (share < wanted_share && state.step < simulation.last_frame()) {
    for (int i = 0; i < frames_between; ++i) step(model, simulation.options, workspace, state);
    share = share_near(begin(), state.positions);
  }
  std::vector<double> searches, steps;
  std::size_t found = 0;
  for (int i = 0; i < repetitions; ++i) {
    auto start = std::chrono::steady_clock::now();
    const ContactStep contact_step = begin();
    steps.push_back(milliseconds_since(start));
    start = std::chrono::steady_clock::now();
    found = surface_candidates(contact_step, LastApart(state.positions), state.positions, 0).size();
    searches.push_back(milliseconds_since(start));
  }
  std::nth_element(searches.begin(), searches.begin() + repetitions / 2, searches.end());
  return {at_most(fmt::format("detection alone, {} bodies, {:.2g} M points, {:.1f} % near: median", model.bodies.size(),
                              1e-6 * double(model.num_points()), 100 * share),
                  searches[repetitions / 2], 20, "ms",
                  fmt::format("{} contacts; beginning the step {:.2g} ms", found, mean(steps)))};
}

// the heap after 20 s, when it should lie still
BenchRows rest() {
  constexpr int steps = 1199, last = 60;
  const Simulation simulation = set_up(load_scene("heap", {parse_override("clip.frames=1200")}));
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  std::vector<double> flight, resting;
  double fastest = 0, ratio = 0;
  int fewest = std::numeric_limits<int>::max(), most = 0, failed = 0;
  for (int i = 0; i < steps; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    const double ms = milliseconds_since(start);
    if (report.contacts == 0 && resting.empty() && i < last) flight.push_back(ms);
    failed += report.status != StepStatus::converged;
    ratio = std::max(ratio, report.max_energy_ratio);
    if (i < steps - last) continue;
    resting.push_back(ms);
    fastest = std::max(fastest, state.velocities.rowwise().norm().maxCoeff());
    fewest = std::min(fewest, report.contacts);
    most = std::max(most, report.contacts);
  }
  return {at_most("heap, last second of 20: fastest node", 1e3 * fastest, 5, "mm/s"),
          {"heap, last second of 20: contacts", fmt::format("{} to {}", fewest, most), "", true},
          at_most("heap, last second of 20: step over flight", mean(resting) / mean(flight), 3, "times",
                  fmt::format("{:.1f} ms, {:.1f} ms", mean(resting), mean(flight))),
          at_most("heap over 20 s: max U/U_max", ratio, 1.001, "",
                  fmt::format("{} of {} steps not converged", failed, steps))};
}

}  // namespace

std::vector<Benchmark> contact_benchmarks() {
  return {{.name = "self-contact", .needs_models = true, .run = armadillo_self_contact},
          {.name = "detection", .slow = true, .run = detection},
          {.name = "rest", .slow = true, .run = rest}};
}

}  // namespace umax
