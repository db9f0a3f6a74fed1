// What the files of the Python module share: arrays, values, errors, long calls. pybind11 itself is in source files alone.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "render/image/image.h"
#include "scenes/scene_value.h"
#include "tools/python/editable_scene.h"

namespace pybind11 {
class module_;
class object;
class handle;
}  // namespace pybind11

namespace umax {

struct State;
struct Simulation;

// One function for each group of the module's names; in this order, as later ones use earlier ones' types.
void bind_errors(pybind11::module_& module);
void bind_scene(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);
void bind_runs(pybind11::module_& module);
void bind_pictures(pybind11::module_& module);
void bind_fit(pybind11::module_& module);

/// A scene from a built-in's name, a path, TOML text or a dict; a Scene as it is.
std::shared_ptr<EditableScene> scene_from(const pybind11::object& source);

/// A Python value as TOML on one line; key: for messages. Throws Error (bad_data).
std::string toml_value(const std::string& key, const pybind11::handle& value);
/// A dict of dicts as a TOML document. Throws Error (bad_data).
std::string toml_document(const pybind11::handle& dict);
/// Numbers, strings, lists and dicts of what TOML has.
pybind11::object python_value(const SceneValue& value);

/// Arrays that own a copy.
pybind11::object array_of(const Points& points);
pybind11::object array_of(const Triangles& triangles);
pybind11::object array_of(const VectorXd& vector);
pybind11::object array_of(const Image& image);   // #H x #W x #C float32
pybind11::object array_of(const Image8& image);  // #H x #W x #C uint8

/// A read-only array in memory that others may change; it keeps the memory alive.
pybind11::object view_of(const std::shared_ptr<const Points>& points);

/// #rows x 3 finite numbers. what: for messages. Throws Error (bad_data).
Points points_from(const pybind11::handle& array, const std::string& what, Eigen::Index rows);
/// A picture of an array #H x #W x #C of uint8, or of floats in [0, 1]. Throws Error (bad_data).
Image8 image_from(const pybind11::handle& array, const std::string& what);

/// Does long work without Python's lock, BLAS on one thread, with standard floating point; all is afterwards as it was. threads:
/// none: all cores.
void long_call(const std::function<void()>& work, std::optional<int> threads = {});

/// Within long work, from any thread: lets Python look for signals every 50 ms, and throws what their handlers raise.
void look_for_signals();

/// Work during which signals are noted by us (see SignalWatch) has ended: those who handle them are told. Throws
/// KeyboardInterrupt if a signal had come.
void pass_on_signal();

/// Python's warnings.warn, of UserWarning. Throws if the caller has made warnings into errors.
void warn(const std::string& text);

/// A state as bytes (those of a state file), and back. Throws Error (bad_data) for one of another model.
pybind11::object bytes_of(const Simulation& simulation, const State& state);
State state_from(const Simulation& simulation, const pybind11::handle& bytes);

}  // namespace umax
