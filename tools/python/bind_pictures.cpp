// umax.render and umax.compare: pictures as arrays.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <fmt/format.h>

#include <utility>

#include "core/base/error.h"
#include "render/image/flip.h"
#include "tools/pages/compare_report.h"
#include "tools/python/bindings.h"
#include "tools/python/picture_view.h"
#include "tools/python/run_reader.h"
#include "tools/python/shared_simulation.h"
#include "tools/run/render_frames.h"
#include "tools/run/run_scene.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace py = pybind11;

namespace umax {
namespace {

constexpr const char* render_doc =
    "render(what, *, size=None, samples=None, engine=None, seed=None, heatmap=None, linear=False, threads=None) -> "
    "array\n\n"
    "A picture: uint8 (height, width, 3) sRGB, rows from the top; of a transparent scene with alpha.\n\n"
    "what:     a Simulation, as it is now; a Frame of a Run, with the bytes of umax render; a Scene, at its start\n"
    "size:     (width, height);  samples: paths a pixel;  engine: 'embree' (path tracer) or 'osmesa' (rasteriser)\n"
    "heatmap:  'none', 'energy', 'multiplier' or 'stretch'. What is None is as the scene's [render] has it.\n"
    "linear:   scene-linear Rec. 709 float32, without tone curve and legend\n\n"
    "Where the scene has no camera, one frames a run's whole motion; of a Simulation, where its bodies were first and "
    "are\n"
    "now. Ctrl-C raises KeyboardInterrupt.";

struct Wishes {
  std::vector<Override> overrides;
  bool linear = false;
  std::optional<int> threads;
};

void add_wish(const char* key, const py::object& value, Wishes& wishes) {
  if (!value.is_none()) wishes.overrides.push_back({key, toml_value(key, value)});
}

/// The simulation's scene shown otherwise, while it lives.
class OtherRender {
 public:
  OtherRender(Simulation& simulation, const RenderDescription& render)
      : simulation_(simulation), own_(std::exchange(simulation.scene.render, render)) {}
  ~OtherRender() { simulation_.scene.render = own_; }
  OtherRender(const OtherRender&) = delete;
  OtherRender& operator=(const OtherRender&) = delete;

 private:
  Simulation& simulation_;
  RenderDescription own_;
};

/// Draws with a painter, without Python's lock; signals are noted meanwhile, and raised afterwards.
py::object draw(Simulation& simulation, const RenderDescription& render, const Wishes& wishes,
                const std::function<std::optional<DrawnPicture>(Painter&)>& with) {
  std::optional<DrawnPicture> drawn;
  const OtherRender other(simulation, render);
  long_call([&] {
    const ThreadLimit threads(wishes.threads);
    const SignalWatch signals;
    Painter painter(render, threads.count());
    drawn = with(painter);
  });
  pass_on_signal();
  return wishes.linear ? array_of(drawn->linear) : array_of(drawn->shown);
}

py::object render_simulation(SharedSimulation& shared, const Wishes& wishes) {
  const SharedSimulation::Busy busy(shared);
  SteppedSimulation& stepped = *shared.stepped;
  Simulation& simulation = stepped.simulation();
  return draw(simulation, shared.scene->with(wishes.overrides).render, wishes, [&](Painter& painter) {
    return painter.draw(shot_of_state(simulation, stepped.initial_state(), stepped.state()));
  });
}

py::object render_frame(const RunFrame& frame, const Wishes& wishes) {
  Simulation& simulation = frame.run->simulation;
  const RenderDescription render =
      wishes.overrides.empty() ? simulation.scene.render : scene_of_run(frame.run->folder, wishes.overrides).render;
  return draw(simulation, render, wishes, [&](Painter& painter) {
    return painter.draw(pictures_of_run(simulation, frame.run->folder, {frame.number}).list, frame.number);
  });
}

py::object render_scene(const EditableScene& scene, const Wishes& wishes) {
  std::unique_ptr<Simulation> simulation;
  const Scene wanted = scene.with(wishes.overrides);
  long_call([&] { simulation = std::make_unique<Simulation>(set_up(wanted)); });
  const State start = rest_state(simulation->model);
  return draw(*simulation, wanted.render, wishes,
              [&](Painter& painter) { return painter.draw(shot_of_state(*simulation, start, start)); });
}

py::object render(const py::object& what, const py::object& size, const py::object& samples, const py::object& engine,
                  const py::object& seed, const py::object& heatmap, bool linear, std::optional<int> threads) {
  Wishes wishes{.overrides = {}, .linear = linear, .threads = threads};
  add_wish("render.size", size, wishes);
  add_wish("render.samples", samples, wishes);
  add_wish("render.engine", engine, wishes);
  add_wish("render.seed", seed, wishes);
  add_wish("render.heatmap", heatmap, wishes);
  if (py::isinstance<SharedSimulation>(what)) return render_simulation(what.cast<SharedSimulation&>(), wishes);
  if (py::isinstance<RunFrame>(what)) return render_frame(what.cast<const RunFrame&>(), wishes);
  return render_scene(*scene_from(what), wishes);
}

/// A file's picture, or an array's.
Image8 picture_from(const py::object& source, const std::string& what) {
  if (py::isinstance<py::str>(source)) return read_for_eyes(source.cast<std::string>());
  if (py::hasattr(source, "__fspath__")) return read_for_eyes(source.attr("__fspath__")().cast<std::string>());
  return image_from(source, what);
}

FlipResult compare(const py::object& reference, const py::object& test) {
  const Image8 a = picture_from(reference, "reference"), b = picture_from(test, "test");
  FlipResult result;
  long_call([&] { result = flip(a, b); });
  return result;
}

}  // namespace

void bind_pictures(py::module_& module) {
  module.def("render", &render, py::arg("what"), py::kw_only(), py::arg("size") = py::none(),
             py::arg("samples") = py::none(), py::arg("engine") = py::none(), py::arg("seed") = py::none(),
             py::arg("heatmap") = py::none(), py::arg("linear") = false, py::arg("threads") = py::none(), render_doc);

  py::class_<FlipResult>(module, "Difference",
                         "How different two pictures look when one alternates between them (FLIP).")
      .def_readonly("mean", &FlipResult::mean, "0: the same, 1: as different as can be.")
      .def_readonly("maximum", &FlipResult::maximum, "Of the pixel that differs most, from 0 to 1.")
      .def_readonly("percent_above", &FlipResult::percent_above, "[%] of the pixels differ by more than 0.1.")
      .def_property_readonly(
          "map", [](const FlipResult& result) { return array_of(result.map); },
          "Of each pixel: float32 (height, width, 1).")
      .def("__repr__", [](const FlipResult& result) {
        return fmt::format("<umax.Difference mean {:.5f}, maximum {:.4f}>", result.mean, result.maximum);
      });
  module.def(
      "compare", &compare, py::arg("reference"), py::arg("test"),
      "compare(reference, test) -> Difference\n\n"
      "Two pictures of one size: paths of PNG, EXR or HDR files, or arrays (height, width, channels) of uint8 or of\n"
      "floats in [0, 1], sRGB. Raises umax.Error where the sizes differ.");
}

}  // namespace umax
