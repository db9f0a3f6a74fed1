// Figures of the simulation, measured in this process on the built-in scenes.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <random>

#include "core/element/rotation.h"
#include "embedding/surface/shapes.h"
#include "scenes/builtin_scenes.h"
#include "scenes/scene_file.h"
#include "tools/benchmarks/bench.h"
#include "tools/setup/simulation_setup.h"

namespace umax {
namespace {

// what a run of steps cost and reached
struct RunFigures {
  std::vector<double> ms;         // every step
  std::vector<double> active_ms;  // steps with a contact or an active limit
  double max_ratio = 0;
  double max_penetration = 0;  // [cells]
  double factorisations = 0;   // per active step
  int max_contacts = 0, last_contacts = 0, max_active_limits = 0;
  std::size_t most_limited = 0;  // the first step with as many active limits
  int not_converged = 0, retried = 0;
};

double mean(const std::vector<double>& values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[std::size_t(share * double(values.size() - 1))];
}

Simulation prepare(const std::string& scene, const std::vector<std::string>& settings) {
  std::vector<Override> overrides;
  for (const std::string& setting : settings) overrides.push_back(parse_override(setting));
  return set_up(load_scene(scene, overrides));
}

RunFigures run(const Simulation& simulation, int steps) {
  RunFigures figures;
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  for (int i = 0; i < steps; ++i) {
    const auto start = std::chrono::steady_clock::now();
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    figures.ms.push_back(ms);
    if (report.contacts > 0 || report.limits_active > 0) {
      figures.active_ms.push_back(ms);
      figures.factorisations += report.factorisations;
    }
    figures.max_ratio = std::max(figures.max_ratio, report.max_energy_ratio);
    figures.max_penetration =
        std::max(figures.max_penetration, report.max_penetration / simulation.model.bodies.front().cell_size);
    figures.max_contacts = std::max(figures.max_contacts, report.contacts);
    if (report.limits_active > figures.max_active_limits) {
      figures.max_active_limits = report.limits_active;
      figures.most_limited = std::size_t(i);
    }
    figures.last_contacts = report.contacts;
    figures.not_converged += report.status != StepStatus::converged;
    figures.retried += report.retries > 0;
  }
  figures.factorisations /= double(std::max<std::size_t>(1, figures.active_ms.size()));
  return figures;
}

void append_limits(const std::string& what, const RunFigures& figures, double tolerance, BenchRows& rows) {
  rows.push_back(at_most(what + ": max U/U_max", figures.max_ratio, 1 + tolerance, "",
                         fmt::format("{} of {} steps not converged, {} retried", figures.not_converged,
                                     figures.ms.size(), figures.retried)));
  rows.push_back(at_most(what + ": deepest vertex", figures.max_penetration, 1e-3, "cells"));
}

BenchRow timing(const std::string& what, const RunFigures& figures, double limit, const std::string& aim) {
  BenchRow row = at_most(what + ": active-step mean", mean(figures.active_ms), limit, "ms",
                         fmt::format("all {:.2f}, 95 % {:.2f}, {:.1f} factors", mean(figures.ms),
                                     percentile(figures.ms, 0.95), figures.factorisations));
  row.target += " (aim " + aim + ")";
  return row;
}

BenchRows armadillo(const std::string& what, std::vector<std::string> settings, double limit, const std::string& aim,
                    double tolerance) {
  settings.push_back("body.armadillo.mesh=" + model_path("armadillo.obj"));
  const Simulation simulation = prepare("armadillo", settings);
  const RunFigures figures = run(simulation, 249);
  BenchRows rows{timing(what, figures, limit, aim)};
  append_limits(what, figures, tolerance, rows);
  return rows;
}

// how hard and deep the limits are held when the fall is higher and the limits are lower
BenchRows armadillo_limits() {
  BenchRows rows;
  for (const char* energy : {"100 J", "20 J", "5 J"}) {
    const Simulation simulation =
        prepare("armadillo", {"body.armadillo.mesh=" + model_path("armadillo.obj"), "body.armadillo.drop_height=2m",
                              std::string("body.armadillo.limit.energy=") + energy});
    const RunFigures figures = run(simulation, 249);
    append_limits(fmt::format("armadillo from 2 m, {}", energy), figures, 1e-3, rows);
    rows.push_back(at_most(
        fmt::format("armadillo from 2 m, {}: steps retried", energy), 100.0 * figures.retried / 249, 1, "%",
        fmt::format("{:.2f} ms an active step, up to {} limits", mean(figures.active_ms), figures.max_active_limits)));
  }
  return rows;
}

// the built-in figure with a fine cage, as far as it takes to land
BenchRows landing(const std::string& cells, int steps, double ms_limit) {
  const RunFigures figures = run(prepare("figure", {"body.figure.cage.cells=" + cells}), steps);
  const std::string what = "figure, " + cells + " hexes";
  const std::size_t falling = figures.ms.size() - figures.active_ms.size();
  BenchRows rows{at_most(what + fmt::format(": mean of {} steps", steps), mean(figures.ms), ms_limit, "ms",
                         fmt::format("{} falling; {:.0f} in contact, at most {} limits, {} contacts", falling,
                                     mean(figures.active_ms), figures.max_active_limits, figures.max_contacts))};
  append_limits(what, figures, 1e-3, rows);
  return rows;
}

BenchRows flat_figure() {
  const Simulation simulation = prepare("figure", {"body.figure.rotation=[-90,0,0]", "body.figure.drop_height=0.02",
                                                   "body.figure.material.damping_mass=2"});
  const RunFigures figures = run(simulation, 180);
  const std::string what = "figure flat on its back";
  return {at_most(what + ": contacts solved, settled", figures.last_contacts, 60, "",
                  fmt::format("{} at most during the fall", figures.max_contacts)),
          at_most(what + ": deepest vertex", figures.max_penetration, 1e-3, "cells"),
          {what + ": active-step mean", fmt::format("{:.2f} ms", mean(figures.active_ms)), "", true}};
}

BenchRows beam() {
  const Simulation simulation = prepare("beam", {"body.beam.limit.energy=0.1J"});
  const RunFigures figures = run(simulation, 200);
  BenchRows rows{at_most("beam, 56 hexes, 0.1 J: active-step mean", mean(figures.active_ms), 1, "ms"),
                 at_most("beam, 56 hexes, 0.1 J: factorisations", figures.factorisations, 4, "a step")};
  append_limits("beam, 56 hexes, 0.1 J", figures, 1e-3, rows);
  return rows;
}

// an impact with nearly every limit active, and the same fall without limits
struct Impact {
  int hexes = 0;
  RunFigures with, without;

  double cost() const { return mean(with.active_ms) / mean(without.active_ms); }
};

// of a sphere in a grid of n^3 cells
Impact sphere_impact(int n) {
  const std::vector<std::string> impact{fmt::format("body.sphere.cage.cells=[{0},{0},{0}]", n),
                                        "body.sphere.cage.clip=filled",
                                        "body.sphere.material.young=50kPa",
                                        "body.sphere.position=[0,1.02,0]",
                                        "body.sphere.velocity=[0,-4.4,0]",
                                        "clip.fps=100"};
  std::vector<std::string> limited = impact, unlimited = impact;
  limited.push_back("body.sphere.limit.density=200J/m^3");
  unlimited.push_back("body.sphere.limit.kind=none");
  constexpr int steps = 12;
  const Simulation with = prepare("sphere", limited);
  return {int(with.model.num_hexes()), run(with, steps), run(prepare("sphere", unlimited), steps)};
}

BenchRows crowded_sphere() {
  const Impact impact = sphere_impact(16);
  BenchRows rows{at_most("sphere, 2.7 k hexes, 200 J/m3: contact step", mean(impact.with.active_ms) / 1e3, 1, "s",
                         fmt::format("{} limits active at most", impact.with.max_active_limits)),
                 at_most("sphere, 2.7 k hexes, 200 J/m3: factorisations", impact.with.factorisations, 13, "a step"),
                 at_most("cost of limits: all active against none", impact.cost(), 5, "x")};
  append_limits("sphere, 2.7 k hexes, 200 J/m3", impact.with, 1e-3, rows);
  return rows;
}

BenchRows large_crowded_sphere() {
  const Impact impact = sphere_impact(54);
  const std::size_t worst = impact.with.most_limited;
  BenchRows rows{at_most("sphere, 89 k hexes, 200 J/m3: cost of limits in its impact", impact.cost(), 5, "x",
                         fmt::format("{:.2f} s, {:.2f} s a step", mean(impact.with.active_ms) / 1e3,
                                     mean(impact.without.active_ms) / 1e3)),
                 {"the step with the most limits",
                  fmt::format("{:.1f} x: {:.2f} s, {} of {} hexes", impact.with.ms[worst] / impact.without.ms[worst],
                              impact.with.ms[worst] / 1e3, impact.with.max_active_limits, impact.hexes),
                  "", true}};
  append_limits("sphere, 89 k hexes, 200 J/m3", impact.with, 1e-3, rows);
  return rows;
}

// every built-in scene that brings its own meshes, over its whole clip
BenchRows builtin_scenes_hold() {
  BenchRows rows;
  for (const BuiltinScene& builtin : builtin_scenes()) {
    if (builtin.name == "armadillo") continue;  // its mesh is not part of the program; see armadillo_limits()
    const Scene scene = load_scene(builtin.name, {});
    const int steps = (scene.clip.frames - 1) * scene.clip.substeps;
    if (scene.bodies.empty() || steps == 0) continue;
    const RunFigures figures = run(set_up(scene), steps);
    const std::string what = "scene " + builtin.name;
    append_limits(what, figures, 1e-3, rows);
    rows.push_back(at_most(
        what + ": steps retried", 100.0 * figures.retried / steps, 1, "%",
        fmt::format("{:.2f} ms an active step, up to {} limits", mean(figures.active_ms), figures.max_active_limits)));
  }
  return rows;
}

// a cube of 4 x 4 x 4 hexes, limited to 20 % stretch, whose nodes start anywhere: does it find its shape in 2 s?
class CrumpledCube {
 public:
  explicit CrumpledCube(unsigned seed) : random_(seed * 7919 + 13) {
    Body cube;
    cube.name = "cube";
    cube.lattice = make_box_lattice({4, 4, 4}, Vector3d::Constant(-0.5), Vector3d::Constant(0.25));
    cube.material.mass = MassModel::lattice;
    cube.limit = {.kind = LimitKind::hard, .unit = LimitUnit::stretch, .value = 0.2};
    cube.surface.weights.resize(0, 8);
    model_ = make_model({cube}, {});
    point_ = vector();
    normal_ = vector().normalized();
  }

  bool recovers(const std::string& kind) {
    State state = rest_state(model_);
    for (Eigen::Index node = 0; node < model_.num_nodes(); ++node)
      state.positions.row(node) = place(kind, model_.rest_positions.row(node).transpose()).transpose();
    StepOptions options;
    options.gravity.setZero();
    Workspace workspace(model_);
    for (int i = 0; i < 120; ++i) {
      const StepReport report = step(model_, options, workspace, state);
      if (!state.positions.allFinite() || (state.been_feasible && report.max_energy_ratio > 1.001)) return false;
    }
    // within its limits everywhere and close to the rest shape: nowhere inverted either (tests/core/test_exact_step)
    return state.been_feasible && shape_error(state.positions) <= 0.05;
  }

 private:
  Vector3d vector() {
    std::uniform_real_distribution<double> share(-0.5, 0.5);
    const double x = share(random_), y = share(random_), z = share(random_);
    return {x, y, z};
  }

  Vector3d place(const std::string& kind, const Vector3d& rest) {
    if (kind == "at random") return vector();
    if (kind == "in a plane") return rest - normal_ * normal_.dot(rest);
    if (kind == "mirrored") return rest - 2 * normal_ * normal_.dot(rest);
    return point_;
  }

  // RMS node distance after rigid alignment, over the diagonal
  double shape_error(const Points& positions) const {
    const Points rest = model_.rest_positions.rowwise() - model_.rest_positions.colwise().mean();
    const Points now = positions.rowwise() - positions.colwise().mean();
    const Matrix3d rotation = polar_rotation(now.transpose() * rest);
    return std::sqrt((now - rest * rotation.transpose()).rowwise().squaredNorm().mean() / 3);
  }

  std::mt19937 random_;
  Model model_;
  Vector3d point_, normal_;
};

BenchRows crumpled_starts() {
  BenchRows rows;
  for (const char* kind : {"at random", "in a plane", "in a point", "mirrored"}) {
    std::string missed;
    int recovered = 0;
    for (unsigned seed = 0; seed < 10; ++seed) {
      if (CrumpledCube(seed).recovers(kind))
        ++recovered;
      else
        missed += fmt::format(" {}", seed);
    }
    rows.push_back({fmt::format("cube whose nodes start {}: recovered", kind), fmt::format("{} of 10", recovered),
                    "10 of 10" + (missed.empty() ? "" : ", missed seeds" + missed), recovered == 10});
  }
  return rows;
}

BenchRows deform_million() {
  const TriangleMesh mesh = make_sphere(1, 8);
  const Lattice lattice = voxelize(mesh, {.size = 365});
  const Embedding embedding = embed(mesh, lattice);
  TriangleMesh out = mesh;
  std::vector<double> ms;
  for (int i = 0; i < 7; ++i) {
    const auto start = std::chrono::steady_clock::now();
    deform(embedding, lattice.hexes, lattice.rest_positions, out);
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  const double per_million = percentile(ms, 0.5) * 1e6 / double(mesh.num_vertices());
  return {at_most("1 M vertices deformed, positions and normals", per_million, 20, "ms",
                  fmt::format("measured on {} vertices", mesh.num_vertices()))};
}

}  // namespace

std::vector<Benchmark> simulation_benchmarks() {
  return {
      {"armadillo", false, true, [] { return armadillo("armadillo, exact", {}, 15, "5", 1e-3); }},
      {"armadillo-free", false, true,
       [] { return armadillo("armadillo without limits", {"body.armadillo.limit.kind=none"}, 8, "3", 1e-3); }},
      {"armadillo-paper", false, true,
       [] {
         return armadillo("armadillo, method paper, 1e-2", {"solver.method=paper", "solver.tolerance=1e-2"}, 15, "8",
                          1e-2);
       }},
      {"armadillo-limits", false, true, armadillo_limits},
      {"figure-3k", false, false, [] { return landing("3000", 59, 1e3); }},
      {"figure-100k", true, false, [] { return landing("100000", 59, 2e3); }},
      {"flat", false, false, flat_figure},
      {"beam", false, false, beam},
      {"crowded", false, false, crowded_sphere},
      {"crowded-89k", true, false, large_crowded_sphere},
      {"scenes", false, false, builtin_scenes_hold},
      {"starts", false, false, crumpled_starts},
      {"deform", false, false, deform_million},
  };
}

}  // namespace umax
