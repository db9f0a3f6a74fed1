// umax.Simulation, umax.StepReport, umax.deform: steps in memory.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <fmt/format.h>

#include "core/base/error.h"
#include "tools/python/bindings.h"
#include "tools/python/shared_simulation.h"
#include "tools/run/steps_csv.h"

namespace py = pybind11;

namespace umax {
namespace {

using Busy = SharedSimulation::Busy;

constexpr const char* simulation_doc =
    "Simulation(scene, threads=None)\n\n"
    "A scene that is simulated in memory, step by step: the same bytes as those of umax simulate. scene: a umax.Scene, "
    "or\n"
    "what makes one; later changes of it do not matter. threads: how many the steps use; None: all cores. The result "
    "is the\n"
    "same for any number.\n\n"
    "Arrays are copies. With copy=False they are read-only views that show the state after every further step.\n"
    "body: a name of bodies; may be left out where there is one.\n"
    "Raises umax.Error for what cannot be simulated; warns (UserWarning) of faults of meshes and overlaps.";

constexpr const char* step_doc =
    "step(forces=None, surface_forces=None) -> StepReport\n\n"
    "One time step of time_step seconds. forces: on nodes [N], during the whole step: an array (nodes, 3), or a dict "
    "of\n"
    "them by body. surface_forces: likewise on vertices of the surface, (vertices, 3); their sum reaches the nodes of "
    "the\n"
    "hexes that hold them, and does the same work. Fixed nodes bear theirs. Other threads of Python run meanwhile, but "
    "may\n"
    "not use this simulation (umax.Error). Ctrl-C raises KeyboardInterrupt, and the state is then as before the step.";

/// Calls add(body, forces) for an array of the only body, or a dict of arrays.
template <class Rows, class Add>
void for_each_force(const Simulation& simulation, const py::object& forces, const char* what, const Rows& rows,
                    const Add& add) {
  if (forces.is_none()) return;
  const auto add_one = [&](const std::string& name, const py::handle& array) {
    const std::size_t body = find_body(simulation, name);
    add(body, points_from(array, fmt::format("{}[\"{}\"]", what, simulation.bodies[body].name),
                          rows(simulation.bodies[body])));
  };
  if (!py::isinstance<py::dict>(forces)) return add_one("", forces);
  for (const auto& [name, array] : py::reinterpret_borrow<py::dict>(forces)) add_one(py::str(name), array);
}

Points all_forces(const Simulation& simulation, const py::object& forces, const py::object& surface_forces) {
  Points all;
  if (forces.is_none() && surface_forces.is_none()) return all;
  all = Points::Zero(simulation.model.num_nodes(), 3);
  for_each_force(
      simulation, forces, "forces", [](const BodySetup& body) { return body.lattice.num_nodes(); },
      [&](std::size_t body, const Points& of_body) { add_nodal_forces(simulation, body, of_body, all); });
  for_each_force(
      simulation, surface_forces, "surface_forces",
      [](const BodySetup& body) { return body.shape.mesh.num_vertices(); },
      [&](std::size_t body, const Points& of_body) { add_surface_forces(simulation, body, of_body, all); });
  return all;
}

std::shared_ptr<SharedSimulation> make_simulation(const py::object& source, std::optional<int> threads) {
  auto shared = std::make_shared<SharedSimulation>();
  shared->scene = std::make_unique<const EditableScene>(*scene_from(source));
  shared->threads = threads;
  long_call([&] { shared->stepped = std::make_unique<SteppedSimulation>(shared->scene->scene(), look_for_signals); },
            threads);
  for (const std::string& warning : shared->stepped->warnings()) warn(warning);
  return shared;
}

StepReport do_step(SharedSimulation& shared, const py::object& forces, const py::object& surface_forces) {
  const Busy busy(shared);
  const Points all = all_forces(shared.stepped->simulation(), forces, surface_forces);
  StepReport report;
  long_call([&] { report = shared.stepped->step(all); }, shared.threads);
  return report;
}

py::object points_of(SharedSimulation& shared, const std::string& body, bool copy, BodyPoints quantity) {
  const Busy busy(shared);
  SteppedSimulation& stepped = *shared.stepped;
  const std::size_t index = find_body(stepped.simulation(), body);
  if (!copy) return view_of(stepped.follow(index, quantity));
  return array_of(points_of_body(stepped.simulation(), stepped.state(), index, quantity));
}

template <BodyPoints quantity>
void def_points(py::class_<SharedSimulation, std::shared_ptr<SharedSimulation>>& type, const char* name,
                const char* doc) {
  type.def(
      name,
      [](SharedSimulation& shared, const std::string& body, bool copy) {
        return points_of(shared, body, copy, quantity);
      },
      py::arg("body") = "", py::kw_only(), py::arg("copy") = true, doc);
}

const BodySetup& body_of(const SharedSimulation& shared, const std::string& name) {
  const Simulation& simulation = shared.stepped->simulation();
  return simulation.bodies[find_body(simulation, name)];
}

void bind_report(py::module_& module) {
  py::class_<StepReport>(module, "StepReport", "What a step did; the names are those of the columns of steps.csv.")
      .def_property_readonly(
          "status", [](const StepReport& report) { return status_name(report.status); },
          "'converged', 'iteration_limit' (more substeps or a looser tolerance help) or 'infeasible'.")
      .def_property_readonly(
          "converged", [](const StepReport& report) { return report.status == StepStatus::converged; },
          "Whether status is 'converged'.")
      .def_readonly("limits_active", &StepReport::limits_active, "Hexes that a limit holds.")
      .def_readonly("contacts", &StepReport::contacts, "Contact constraints solved.")
      .def_readonly("sqp_iterations", &StepReport::sqp_iterations, "Iterations of the step.")
      .def_readonly("factorisations", &StepReport::factorisations, "Matrices factored, or multigrids set up.")
      .def_readonly("linear_iterations", &StepReport::linear_iterations,
                    "Gauss-Seidel sweeps and iterations of the linear solver.")
      .def_readonly("retries", &StepReport::retries, "Attempts at smaller step sizes.")
      .def_readonly("max_energy_ratio", &StepReport::max_energy_ratio, "Largest U/U_max at the end; 0: no limits.")
      .def_readonly("kkt_residual", &StepReport::kkt_residual,
                    "[-] Gradient of the Lagrangian over the largest force of any one kind.")
      .def_readonly("max_penetration", &StepReport::max_penetration, "[m] Depth of the deepest vertex at the end.")
      .def_readonly("kinetic_energy", &StepReport::kinetic_energy, "[J] of the nodes' velocities at the end.")
      .def_readonly("elastic_energy", &StepReport::elastic_energy, "[J] of all hexes at the end.")
      .def_readonly("potential_energy", &StepReport::potential_energy, "[J] of gravity, 0 at height 0.")
      .def("__repr__", [](const StepReport& report) {
        return fmt::format("<umax.StepReport {}: {} limits, {} contacts, max_energy_ratio {:.4g}>",
                           status_name(report.status), report.limits_active, report.contacts, report.max_energy_ratio);
      });
}

void bind_facts(py::class_<SharedSimulation, std::shared_ptr<SharedSimulation>>& type) {
  type.def_property_readonly(
          "bodies",
          [](const SharedSimulation& shared) {
            std::vector<std::string> names;
            for (const BodySetup& body : shared.stepped->simulation().bodies) names.push_back(body.name);
            return names;
          },
          "Names of the bodies, in alphabetical order.")
      .def_property_readonly(
          "time", [](const SharedSimulation& s) { return s.stepped->state().time; }, "[s] of the state.")
      .def_property_readonly(
          "steps", [](const SharedSimulation& s) { return s.stepped->state().step; },
          "Time steps that led to the state.")
      .def_property_readonly(
          "time_step", [](const SharedSimulation& s) { return s.stepped->simulation().options.time_step; },
          "[s] 1 / (clip.fps clip.substeps)")
      .def(
          "triangles",
          [](const SharedSimulation& s, const std::string& b) { return array_of(body_of(s, b).shape.mesh.triangles); },
          py::arg("body") = "", "Of the body's surface: int32 (triangles, 3), indices into surface().")
      .def(
          "hexes",
          [](const SharedSimulation& s, const std::string& b) {
            const Hexes& hexes = body_of(s, b).lattice.hexes;
            return py::array_t<int>({hexes.rows(), Eigen::Index(8)}, hexes.data());
          },
          py::arg("body") = "", "Of the body's cage: int32 (hexes, 8), indices into positions().");
}

}  // namespace

void bind_simulation(py::module_& module) {
  bind_report(module);
  py::class_<SharedSimulation, std::shared_ptr<SharedSimulation>> type(module, "Simulation", simulation_doc);
  type.def(py::init(&make_simulation), py::arg("scene"), py::kw_only(), py::arg("threads") = py::none());
  type.def("step", &do_step, py::arg("forces") = py::none(), py::arg("surface_forces") = py::none(), step_doc);
  def_points<BodyPoints::positions>(type, "positions", "Of the cage's nodes [m]: float64 (nodes, 3).");
  def_points<BodyPoints::velocities>(type, "velocities", "Of the cage's nodes [m/s]: float64 (nodes, 3).");
  def_points<BodyPoints::surface>(type, "surface",
                                  "Of the mesh's vertices [m], in the order of its file: float64 (vertices, 3).");
  type.def(
      "energy_ratios",
      [](SharedSimulation& shared, const std::string& body) {
        const Busy busy(shared);
        const Simulation& simulation = shared.stepped->simulation();
        return array_of(energy_ratios_of_body(simulation, shared.stepped->state(), find_body(simulation, body)));
      },
      py::arg("body") = "", "U/U_max of each hex's worst limit [-], 0 where it has none: float64 (hexes,).");
  type.def(
      "state",
      [](SharedSimulation& shared) {
        const Busy busy(shared);
        return bytes_of(shared.stepped->simulation(), shared.stepped->state());
      },
      "All that influences later steps, as bytes: those of a run's states/NNNN.state.");
  type.def(
      "restore",
      [](SharedSimulation& shared, const py::bytes& state) {
        const Busy busy(shared);
        shared.stepped->restore(state_from(shared.stepped->simulation(), state));
      },
      py::arg("state"), "Goes to a state of this scene. Raises umax.Error for a damaged one, or another scene's.");
  bind_facts(type);
  type.def("__repr__", [](const SharedSimulation& shared) {
    return fmt::format("<umax.Simulation {} at {:.4g} s>", shared.stepped->simulation().scene.name,
                       shared.stepped->state().time);
  });

  module.def(
      "deform",
      [](SharedSimulation& shared, const std::string& body, const py::object& nodes) {
        const Simulation& simulation = shared.stepped->simulation();
        const std::size_t index = find_body(simulation, body);
        return array_of(surface_of_body(simulation, index,
                                        points_from(nodes, "nodes", simulation.bodies[index].lattice.num_nodes())));
      },
      py::arg("simulation"), py::arg("body"), py::arg("nodes"),
      "deform(simulation, body, nodes) -> array\n\n"
      "Where the body's surface is [m] for any positions of its cage's nodes, (nodes, 3) [m]: float64 (vertices, 3).\n"
      "Raises umax.Error for another shape, or a body that is not there.");
}

}  // namespace umax
