// umax.Scene: what is to be simulated and shown, changed key by key.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "core/base/error.h"
#include "scenes/builtin_scenes.h"
#include "scenes/resolved_scene.h"
#include "tools/python/bindings.h"

namespace py = pybind11;

namespace umax {
namespace {

constexpr const char* scene_doc =
    "Scene(source)\n\n"
    "What is to be simulated and shown. source: the name of a built-in scene (umax.scenes() lists them), the path of a "
    ".toml\n"
    "file, TOML text (a str with a line break or a =), or a dict of dicts. Relative paths in text and dicts start at "
    "the\n"
    "current folder.\n\n"
    "scene[key] = value sets a key as --set of the command line does: scene['body.cow.limit.stretch'] = '15 %'. Values "
    "are\n"
    "numbers in SI units, strings with units, bools, lists, dicts or numpy arrays. What does not fit is refused with "
    "the\n"
    "reader's own umax.Error, and the scene stays as it was.\n\n"
    "scene[key] is the value as resolved, in SI units; of a table such as scene['body.cow'] a dict.";

SceneText text_from(const py::object& source) {
  if (py::isinstance<py::dict>(source)) return {.text = toml_document(source), .file = "the scene's dict"};
  if (py::hasattr(source, "__fspath__")) return find_scene(source.attr("__fspath__")().cast<std::string>());
  if (!py::isinstance<py::str>(source))
    throw Error(Fault::bad_data, {.where = "Scene",
                                  .what = "cannot be made of this",
                                  .value = py::str(py::type::of(source)),
                                  .remedy = "give a built-in's name, a path, TOML text or a dict"});
  const auto text = source.cast<std::string>();
  if (text.find_first_of("\n=") == std::string::npos) return find_scene(text);
  return {.text = text, .file = "the scene's text"};
}

std::string representation(const EditableScene& scene) {
  return "<umax.Scene " + scene.scene().name + ": " + std::to_string(scene.scene().bodies.size()) + " bodies, " +
         std::to_string(scene.scene().clip.frames) + " frames>";
}

std::vector<std::string> names_of_bodies(const EditableScene& scene) {
  std::vector<std::string> names;
  for (const BodyDescription& body : scene.scene().bodies) names.push_back(body.name);
  return names;
}

}  // namespace

std::shared_ptr<EditableScene> scene_from(const py::object& source) {
  if (py::isinstance<EditableScene>(source)) return source.cast<std::shared_ptr<EditableScene>>();
  const SceneText text = text_from(source);
  return std::make_shared<EditableScene>(text);
}

void bind_scene(py::module_& module) {
  py::class_<EditableScene, std::shared_ptr<EditableScene>>(module, "Scene", scene_doc)
      .def(py::init([](const py::object& source) {
             return py::isinstance<EditableScene>(source) ? std::make_shared<EditableScene>(*scene_from(source))
                                                          : scene_from(source);
           }),
           py::arg("source"))
      .def("__setitem__", [](EditableScene& scene, const std::string& key,
                             const py::object& value) { scene.set(key, toml_value(key, value)); })
      .def("__getitem__",
           [](const EditableScene& scene, const std::string& key) { return python_value(scene.get(key)); })
      .def(
          "copy", [](const EditableScene& scene) { return EditableScene(scene); }, "Another one, to be changed apart.")
      .def(
          "toml", [](const EditableScene& scene) { return resolved_toml(scene.scene()); },
          "The scene as resolved, every default written out: what a run's scene.toml has.")
      .def_property_readonly(
          "name", [](const EditableScene& scene) { return scene.scene().name; },
          "Stem of the file, the built-in's name, or 'scene'.")
      .def_property_readonly("bodies", names_of_bodies, "Names of the bodies, in alphabetical order.")
      .def("__repr__", representation);

  module.def(
      "scenes",
      [] {
        py::dict scenes;
        for (const BuiltinScene& scene : builtin_scenes()) scenes[py::str(scene.name)] = scene.description;
        return scenes;
      },
      "scenes() -> dict\n\nNames of the built-in scenes, and what they show.");
}

}  // namespace umax
