#include "tools/benchmarks/bench_penetration.h"

#include <fmt/format.h>

#include <chrono>

#include "scenes/scene_file.h"

namespace umax {
namespace {

constexpr double allowed = 2e-2;  // [cells]

std::string remark(const Simulation& simulation) {
  Eigen::Index vertices = 0;
  for (const BodySetup& body : simulation.bodies) vertices += body.shape.mesh.num_vertices();
  return fmt::format("{} vertices", vertices);
}

// the built-in scene `figure` over its whole clip, every frame, with limbs that may touch each other
BenchRows figure_penetration() {
  const Simulation simulation = set_up(load_scene("figure", {parse_override("body.figure.contact=all")}));
  const std::vector<test::MeasuredBody> bodies = measured_bodies(simulation);
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  WorstPenetration worst;
  for (int frame = 1; frame < simulation.last_frame(); ++frame) {
    for (int i = 0; i < simulation.scene.clip.substeps; ++i)
      step(simulation.model, simulation.options, workspace, state);
    measure(simulation, bodies, state, worst);
  }
  BenchRows rows;
  append_penetration("figure", worst, rows);
  rows.push_back({"figure: time to measure a frame",
                  fmt::format("{:.3g} s, {}", worst.seconds / worst.states, remark(simulation)), "", true});
  return rows;
}

}  // namespace

std::vector<test::MeasuredBody> measured_bodies(const Simulation& simulation) {
  std::vector<test::MeasuredBody> bodies;
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i)
    bodies.push_back(test::measured_body(simulation.model, int(i), simulation.bodies[i].shape.mesh.triangles));
  return bodies;
}

void measure(const Simulation& simulation, const std::vector<test::MeasuredBody>& bodies, const State& state,
             WorstPenetration& worst) {
  const auto start = std::chrono::steady_clock::now();
  test::add(test::measure_penetration(simulation.model, bodies, state.positions), worst.worst);
  worst.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ++worst.states;
}

void append_penetration(const std::string& what, const WorstPenetration& worst, BenchRows& rows) {
  const test::PenetrationReport& report = worst.worst;
  rows.push_back(at_most(what + ": deepest point inside another body", report.between.cells, allowed, "cells",
                         fmt::format("{:.2g} m", report.between.depth)));
  rows.push_back(at_most(what + ": deepest point inside its own body", report.within.cells, allowed, "cells",
                         fmt::format("{:.2g} m", report.within.depth)));
  rows.push_back(at_most(what + ": deepest edge that crosses a surface", report.crossing.cells, allowed, "cells",
                         fmt::format("{} crossings in {} frames", report.edges_crossing, worst.states)));
}

std::vector<Benchmark> penetration_benchmarks() {
  return {{.name = "penetration", .run = figure_penetration}};
}

}  // namespace umax
