// umax.simulate, umax.Run, umax.Frame: runs in folders, as the program umax makes and reads them.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <fmt/format.h>

#include <csignal>
#include <exception>

#include "core/base/error.h"
#include "tools/python/bindings.h"
#include "tools/python/run_reader.h"
#include "tools/run/job.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace py = pybind11;

namespace umax {
namespace {

constexpr const char* simulate_doc =
    "simulate(scene, out, *, progress=None, frames=None, resume=False, overwrite=False, strict=False, threads=None) -> "
    "Run\n\n"
    "umax simulate: states and steps.csv into the folder out, byte by byte as the program writes them.\n\n"
    "scene:      a umax.Scene, or what makes one\n"
    "progress:   called after each frame with a Progress; what it raises ends the run, and is raised\n"
    "frames:     '1-40', or how many; None: all of the clip. Neighbours that pictures of them show are simulated, "
    "too.\n"
    "resume:     go on with what is in out;  overwrite: remove it first. Without either an existing folder is "
    "refused.\n"
    "strict:     a step that does not converge ends the run (umax.Error, exit_code 75)\n"
    "threads:    None: all cores. The result is the same for any number.\n\n"
    "Ctrl-C raises KeyboardInterrupt at the end of an iteration; the frames before are kept, and resume=True goes on.";

/// What a run tells Python. A listener is called in the midst of C++, which no exception of Python's may cross: it is kept,
/// and the run asked to stop as by a signal.
struct Listening {
  py::object progress;
  std::exception_ptr raised;
  std::vector<std::string> warnings;

  ProgressListener listener() {
    ProgressListener told;
    told.warning = [this](const std::string& text) { warnings.push_back(text); };
    told.frame_done = [this](const ProgressLine& line) {
      if (progress.is_none() || raised) return;
      const py::gil_scoped_acquire locked;
      try {
        progress(line);
      } catch (...) {
        raised = std::current_exception();
        std::raise(SIGINT);
      }
    };
    return told;
  }
};

struct SimulateWishes {
  std::optional<std::string> frames;
  bool resume = false, overwrite = false, strict = false;
  std::optional<int> threads;
};

/// Does the job, and returns its exit code once everything is in Python's hands again.
int do_simulate(const Scene& scene, const std::filesystem::path& out, const SimulateWishes& wishes,
                Listening& listening) {
  Job job;
  job.scene = scene;
  job.folder = out;
  job.existing = wishes.overwrite ? ExistingFolder::overwrite
                 : wishes.resume  ? ExistingFolder::keep
                                  : ExistingFolder::refuse;
  job.pictures = false;
  int code = 0;
  long_call([&] {
    const SignalWatch signals;  // from before the scene is set up
    const ThreadLimit threads(wishes.threads);
    Progress progress(listening.listener());
    code =
        do_job(job, {.verb = "simulate", .frames = wishes.frames, .threads = threads.count(), .strict = wishes.strict},
               progress);
  });
  return code;
}

std::optional<std::string> frame_list(const py::object& frames) {
  if (frames.is_none()) return std::nullopt;
  if (py::isinstance<py::int_>(frames)) return "1-" + std::string(py::str(frames));
  return py::str(frames);
}

std::shared_ptr<RunReader> simulate_scene(const py::object& scene, const std::filesystem::path& out,
                                          const py::object& progress, const py::object& frames, bool resume,
                                          bool overwrite, bool strict, std::optional<int> threads) {
  if (resume && overwrite)
    throw Error(Fault::usage, {.where = "simulate",
                               .what = "resume and overwrite exclude each other",
                               .value = "",
                               .remedy = "give one of them"});
  const std::shared_ptr<EditableScene> from = scene_from(scene);
  Listening listening{progress, nullptr, {}};
  const SimulateWishes wishes{frame_list(frames), resume, overwrite, strict, threads};
  const int code = do_simulate(from->scene(), out, wishes, listening);
  if (listening.raised) {
    forget_stop();
    std::rethrow_exception(listening.raised);
  }
  if (code != 0) pass_on_signal();
  for (const std::string& warning : listening.warnings) warn(warning);
  std::shared_ptr<RunReader> run;
  long_call([&] { run = open_run(out); });
  return run;
}

template <BodyPoints quantity>
py::object points_of_frame(const RunFrame& frame, const std::string& body) {
  const Simulation& simulation = frame.run->simulation;
  return array_of(points_of_body(simulation, frame.state, find_body(simulation, body), quantity));
}

RunFrame frame_at(const std::shared_ptr<RunReader>& run, int number) {
  std::optional<RunFrame> frame;
  long_call([&] { frame = read_frame(run, number); });
  return std::move(*frame);
}

/// An iterator over the frames that are there when they are asked for.
struct FrameIterator {
  std::shared_ptr<RunReader> run;
  int next = 1;
};

void bind_progress(py::module_& module) {
  py::class_<ProgressLine>(module, "Progress", "How far a run is.")
      .def_readonly("stage", &ProgressLine::stage, "'simulate'")
      .def_readonly("frame", &ProgressLine::frame, "The frame just finished.")
      .def_readonly("done", &ProgressLine::done, "Frames that are finished.")
      .def_readonly("total", &ProgressLine::total, "Frames in all.")
      .def_readonly("elapsed", &ProgressLine::elapsed, "[s] since the run began.")
      .def_readonly("detail", &ProgressLine::detail, "What the program says beside the frame.")
      .def("__repr__", [](const ProgressLine& line) {
        return fmt::format("<umax.Progress {} {}/{}>", line.stage, line.done, line.total);
      });
}

void bind_frame(py::module_& module) {
  py::class_<RunFrame>(module, "Frame", "One frame of a Run. body: a name; may be left out where there is one.")
      .def_readonly("number", &RunFrame::number, "From 1, the initial state.")
      .def_property_readonly(
          "time", [](const RunFrame& frame) { return frame.state.time; }, "[s] since the clip began.")
      .def("positions", &points_of_frame<BodyPoints::positions>, py::arg("body") = "",
           "Of the cage's nodes [m]: float64 (nodes, 3).")
      .def("velocities", &points_of_frame<BodyPoints::velocities>, py::arg("body") = "",
           "Of the cage's nodes [m/s]: float64 (nodes, 3).")
      .def("surface", &points_of_frame<BodyPoints::surface>, py::arg("body") = "",
           "Of the mesh's vertices [m], in the order of its file: float64 (vertices, 3).")
      .def(
          "energy_ratios",
          [](const RunFrame& frame, const std::string& body) {
            const Simulation& simulation = frame.run->simulation;
            return array_of(energy_ratios_of_body(simulation, frame.state, find_body(simulation, body)));
          },
          py::arg("body") = "", "U/U_max of each hex's worst limit [-], 0 where it has none: float64 (hexes,).")
      .def(
          "state", [](const RunFrame& frame) { return bytes_of(frame.run->simulation, frame.state); },
          "The bytes of its states/NNNN.state; Simulation.restore() takes them.")
      .def("__repr__", [](const RunFrame& frame) {
        return fmt::format("<umax.Frame {} at {:.4g} s>", frame.number, frame.state.time);
      });
}

py::object steps_of(const RunReader& run) {
  py::dict columns;
  for (const auto& [name, values] : step_columns(run))
    columns[py::str(name)] = array_of(VectorXd(Eigen::Map<const VectorXd>(values.data(), Eigen::Index(values.size()))));
  return columns;
}

std::vector<std::string> bodies_of(const RunReader& run) {
  std::vector<std::string> names;
  for (const BodySetup& body : run.simulation.bodies) names.push_back(body.name);
  return names;
}

void bind_run(py::module_& module) {
  py::class_<FrameIterator>(module, "FrameIterator", "Over the frames of a Run, which are read one by one.")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", [](FrameIterator& at) {
        if (at.next > num_frames(*at.run)) throw py::stop_iteration();
        return frame_at(at.run, at.next++);
      });
  py::class_<RunReader, std::shared_ptr<RunReader>>(
      module, "Run",
      "Run(folder)\n\nThe folder of a run: for frame in run, len(run), run[0] the first and run[-1] the last frame.\n"
      "Raises umax.Error where no run is, or a damaged one, and for a body that is not there; IndexError past the end.")
      .def(py::init([](const std::filesystem::path& folder) {
             std::shared_ptr<RunReader> run;
             long_call([&] { run = open_run(folder); });
             return run;
           }),
           py::arg("folder"))
      .def_property_readonly(
          "folder", [](const RunReader& run) { return run.folder; }, "Where the run is: a pathlib.Path.")
      .def_property_readonly("bodies", &bodies_of, "Names of the bodies, in alphabetical order.")
      .def_property_readonly("steps", &steps_of,
                             "The columns of steps.csv by name, float64 (steps,); converged is 1 or 0.")
      .def(
          "triangles",
          [](const RunReader& run, const std::string& body) {
            return array_of(run.simulation.bodies[find_body(run.simulation, body)].shape.mesh.triangles);
          },
          py::arg("body") = "", "Of the body's surface: int32 (triangles, 3), indices into surface().")
      .def("__len__", &num_frames)
      .def("__getitem__",
           [](const std::shared_ptr<RunReader>& run, py::ssize_t index) {
             const py::ssize_t count = num_frames(*run), place = index < 0 ? index + count : index;
             if (place < 0 || place >= count) throw py::index_error("the run has " + std::to_string(count) + " frames");
             return frame_at(run, int(place) + 1);
           })
      .def("__iter__", [](const std::shared_ptr<RunReader>& run) { return FrameIterator{run}; })
      .def("__repr__", [](const RunReader& run) {
        return fmt::format("<umax.Run {}: {} frames>", run.folder.string(), num_frames(run));
      });
}

}  // namespace

py::object bytes_of(const Simulation& simulation, const State& state) {
  return py::bytes(encode_state(state, simulation.digest));
}

State state_from(const Simulation& simulation, const py::handle& bytes) {
  Digest made_with;
  const std::string text = py::reinterpret_borrow<py::bytes>(bytes);
  State state = decode_state(text, "state", made_with);
  require_state_of(simulation.model, simulation.digest, "state", state, made_with);
  return state;
}

void bind_runs(py::module_& module) {
  bind_progress(module);
  bind_frame(module);
  bind_run(module);
  module.def("simulate", &simulate_scene, py::arg("scene"), py::arg("out"), py::kw_only(),
             py::arg("progress") = py::none(), py::arg("frames") = py::none(), py::arg("resume") = false,
             py::arg("overwrite") = false, py::arg("strict") = false, py::arg("threads") = py::none(), simulate_doc);
}

}  // namespace umax
