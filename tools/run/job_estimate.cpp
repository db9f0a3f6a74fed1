#include "tools/run/job_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/error.h"
#include "core/problem/linear_plan.h"
#include "core/step/multigrid_system.h"
#include "tools/system/machine_memory.h"
#include "tools/system/progress.h"

namespace umax {
namespace {

// Measured on two cores (AMD EPYC), `umax simulate` of figure and beam, peak of the whole process:
//   direct      2,996 hexes 234 MB (380 MB with 54 contacts), 10,000 451 MB, 27,000 (a cube) 1,047 MB, 30,001
//               1,346 MB, 97,336 (a cube) 5,065 MB, 99,666 (a bar) 3,430 MB
//   multigrid   100,003 hexes 576 MB (27,900 of them at their limits), 1,000,053 3,409 MB (279,500); 91,125 (a cube)
//               452 MB (51,000); 22,500 (a sheet, one cell thick) 419 MB; 20,000 (a rod of single cells) 1,110 MB
constexpr double program_bytes = 100e6;           // with no body
constexpr double bytes_per_vertex = 700;          // the figure with 365 hexes and 116,000 of them: 183 MB
constexpr double bytes_per_hex = 2200;            // cage, model, limits
constexpr double state_bytes_per_hex = 500;       // of the direct solver: what its matrix is made of
constexpr double multigrid_bytes_per_slot = 600;  // its levels and directions
constexpr double multigrid_bytes_per_hex = 300;   // limits at work
constexpr double slots_per_node = 1.2;            // of a compact body
constexpr double bytes_per_irregular_hex = 12e3;  // its matrices
constexpr double factor_bytes = 950;              // of the direct solver, times nodes^(4/3)

// One Newton iteration, a step of the figure from rest takes 2: direct 0.9 s with 13,020 nodes, 7.1 s with 36,358; the
// cube of 103,823 nodes 176 s a step; multigrid 0.65 s with 100,003 hexes, 8 s with 1,000,053 (0.2 s and 2 s are aimed
// at). A clip of the figure with 365 hexes: steps of 55 ms and 4.5 iterations on the average.
constexpr double direct_seconds = 6e-9;               // times nodes^2
constexpr double direct_seconds_per_hex = 2e-5;       // assembly
constexpr double multigrid_seconds_per_hex = 3.5e-6;  // falling; contacts and limits take several times that
constexpr double newton_iterations = 5;               // a step, on the average of a clip with contacts and limits

constexpr double worth_saying_bytes = 1 << 30, worth_saying_seconds = 600;

double factor_memory(const BodySize& body) {
  return factor_bytes * std::pow(body.nodes, 4.0 / 3);
}

double nodes_of_compact(double hexes) {
  const double edge = std::cbrt(hexes) + 1;
  return edge * edge * edge;
}

/// What of the bounding box the built-in shapes fill; other shapes are known when they are read.
double filled_share(const BodyDescription& body) {
  if (body.cage.clip == CageDescription::Clip::box) return 1;
  if (std::holds_alternative<SphereShape>(body.source)) return std::numbers::pi / 6;
  const bool upright = body.rotation_degrees.isZero();  // else its box is larger than it
  if (upright && std::holds_alternative<BoxShape>(body.source)) return 1;
  if (upright && std::holds_alternative<CylinderShape>(body.source)) return std::numbers::pi / 4;
  return 0;
}

/// At least so many hexes; 0 where the scene's text does not tell.
double hexes_told(const BodyDescription& body) {
  if (body.brings_its_hexes()) return 0;
  if (const int* count = std::get_if<int>(&body.cage.size)) return *count;
  if (const auto* grid = std::get_if<Vector3i>(&body.cage.size))
    return filled_share(body) * grid->cast<double>().prod();
  return 0;
}

/// Is the body's cage made of cells of one grid?
bool is_regular(const BodyDescription& body) {
  return !body.brings_its_hexes() && !std::holds_alternative<MeshSource>(body.cage.size);
}

void set_solver(const LinearPlan& plan, JobSize& size) {
  size.multigrid = plan.is_multigrid();
  size.may_multigrid = !plan.against_multigrid;
}

JobSize with_multigrid(JobSize size) {
  size.multigrid = true;
  return size;
}

/// The same bodies with at most so many hexes each.
JobSize coarser(JobSize size, double most_hexes) {
  for (BodySize& body : size.bodies) {
    if (body.hexes <= most_hexes) continue;
    body.nodes = std::max(nodes_of_compact(most_hexes), body.nodes * most_hexes / body.hexes);
    body.slots *= most_hexes / body.hexes;
    body.hexes = most_hexes;
  }
  return size;
}

/// The most hexes a body with which the job fits; less than 1: none.
double hexes_that_fit(const JobSize& size, double largest, double memory) {
  double low = 0, high = largest;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (estimate(coarser(size, middle)).memory > memory ? high : low) = middle;
  }
  return low;
}

/// 123456 -> 120000: two digits, downwards.
long long rounded_down(double number) {
  const double unit = std::pow(10, std::max(0.0, std::floor(std::log10(std::max(1.0, number))) - 1));
  return (long long)(std::floor(number / unit) * unit);
}

/// How to ask for a cage of so many hexes in place of those that it has.
std::string coarser_cage(const BodyDescription& body, double hexes, double wanted) {
  if (body.brings_its_hexes() || std::holds_alternative<MeshSource>(body.cage.size))
    return fmt::format("give a mesh of at most {} hexes", rounded_down(wanted));
  if (const double* edge = std::get_if<double>(&body.cage.size))
    return fmt::format("set cage.cell_size to at least {:.2g} m", 1.05 * *edge * std::cbrt(hexes / wanted));
  return fmt::format("set cage.cells to at most {}", rounded_down(wanted));
}

std::string advice(const JobSize& size, const Scene& scene, const BodySize& largest, double memory) {
  std::vector<std::string> ways;
  const double wanted = hexes_that_fit(size, largest.hexes, memory);
  for (const BodyDescription& body : scene.bodies)
    if (body.name == largest.name && wanted >= 1)
      ways.push_back(coarser_cage(body, largest.hexes, wanted) + (scene.bodies.size() > 1 ? ", of every body" : ""));
  if (!size.multigrid && size.may_multigrid)
    if (const double other = estimate(with_multigrid(size)).memory; other <= memory)
      ways.push_back(fmt::format("solver.linear = multigrid (about {})", format_memory(other)));
  const double gib = std::ceil(1.1 * estimate(size).memory / (1 << 30));
  ways.push_back(fmt::format("--memory {:.0f}G if you know better", gib));
  return fmt::format("{}", fmt::join(ways, ", or "));
}

const char* solver_name(const JobSize& size) {
  return size.multigrid ? "multigrid" : "direct";
}

}  // namespace

JobSize size_of(const Scene& scene) {
  JobSize size;
  std::vector<LinearTraits> traits;
  for (const BodyDescription& body : scene.bodies) {
    const double hexes = hexes_told(body);
    const double nodes = hexes > 0 ? nodes_of_compact(hexes) : 0;
    size.bodies.push_back({.name = body.name, .hexes = hexes, .nodes = nodes, .slots = slots_per_node * nodes});
    traits.push_back({.name = body.name, .hexes = hexes, .is_regular = is_regular(body)});
  }
  SolverOptions solver = scene.solver;
  if (solver.linear == LinearSolver::automatic) solver.linear = LinearSolver::multigrid;  // where it can, it needs less
  set_solver(plan_linear_solvers(traits, solver), size);
  return size;
}

JobSize size_of(const Scene& scene, const std::vector<BodySetup>& caged) {
  JobSize size = size_of(scene);
  for (std::size_t i = 0; i < caged.size(); ++i)
    size.bodies[i] = {.name = caged[i].name,
                      .hexes = double(caged[i].lattice.num_hexes()),
                      .nodes = double(caged[i].lattice.num_nodes()),
                      .slots = multigrid_slots(caged[i].lattice.cells),
                      .vertices = double(caged[i].shape.mesh.num_vertices()),
                      .irregular = !caged[i].lattice.is_regular()};
  return size;
}

JobSize size_of(const Simulation& simulation) {
  JobSize size;
  set_solver(plan_linear_solvers(simulation.model, simulation.options.solver), size);
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i) {
    const Model::BodyRange& body = simulation.model.bodies[i];
    size.bodies.push_back({.name = body.name,
                           .hexes = double(body.num_hexes),
                           .nodes = double(body.num_nodes),
                           .slots = multigrid_slots(body.cells),
                           .vertices = double(simulation.bodies[i].shape.mesh.num_vertices()),
                           .irregular = body.cells.rows() == 0});
  }
  return size;
}

double lattice_memory(const JobSize& size) {
  double bytes = 0;
  for (const BodySize& body : size.bodies) {
    bytes += bytes_per_hex * body.hexes;
    if (body.irregular) bytes += bytes_per_irregular_hex * body.hexes;
    bytes += size.multigrid ? multigrid_bytes_per_slot * body.slots + multigrid_bytes_per_hex * body.hexes
                            : factor_memory(body) + state_bytes_per_hex * body.hexes;
  }
  return bytes;
}

JobEstimate estimate(const JobSize& size) {
  JobEstimate result{.memory = program_bytes + lattice_memory(size)};
  double iteration = 0;
  for (const BodySize& body : size.bodies) {
    result.memory += bytes_per_vertex * body.vertices;
    iteration += size.multigrid ? multigrid_seconds_per_hex * body.hexes
                                : direct_seconds * body.nodes * body.nodes + direct_seconds_per_hex * body.hexes;
  }
  result.step_seconds = newton_iterations * iteration;
  return result;
}

void require_memory(const JobSize& size, const Scene& scene, double memory) {
  const double needed = estimate(size).memory;
  if (needed <= memory || size.bodies.empty()) return;
  const BodySize& largest = *std::max_element(size.bodies.begin(), size.bodies.end(),
                                              [](const auto& a, const auto& b) { return a.hexes < b.hexes; });
  double hexes = 0;
  for (const BodySize& body : size.bodies) hexes += body.hexes;
  throw Error(Fault::bad_data,
              {.where = fmt::format("body.{}.cage", largest.name),
               .what = fmt::format("{:.0f} hexes with solver.linear = {} need about {} of memory, and there are {}",
                                   hexes, solver_name(size), format_memory(needed), format_memory(memory)),
               .remedy = advice(size, scene, largest, memory)});
}

bool is_worth_saying(double memory, double seconds) {
  return memory > worth_saying_bytes || seconds > worth_saying_seconds;
}

std::string seconds_text(double seconds) {
  return seconds < 10 ? fmt::format("{:.2g}", seconds) : fmt::format("{:.0f}", seconds);
}

std::string announce(const JobSize& size, long long steps) {
  const JobEstimate cost = estimate(size);
  const double seconds = double(steps) * cost.step_seconds;
  if (!is_worth_saying(cost.memory, seconds)) return {};
  return fmt::format("about {} of memory and {} ({} steps of about {} s) with solver.linear = {}",
                     format_memory(cost.memory), format_duration(seconds), steps, seconds_text(cost.step_seconds),
                     solver_name(size));
}

}  // namespace umax
