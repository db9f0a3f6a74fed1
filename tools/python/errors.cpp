// umax.Error: an Error of ours as Python has it.
#include <pybind11/pybind11.h>

#include "core/base/error.h"
#include "tools/python/bindings.h"
#include "tools/system/exit_code.h"

namespace py = pybind11;

namespace umax {
namespace {

constexpr const char* doc =
    "Something that you can mend. str() has all of it in one line.\n\n"
    "where:      what is wrong: 'scene.toml:12: body.cow.limit.stretch', 'scene[\"clip.frames\"]', a file\n"
    "what:       'must be positive'\n"
    "value:      as it was given; '' where there is none\n"
    "remedy:     what mends it\n"
    "exit_code:  that the program umax would end with: 65 bad data, 66 not found, 69 a helper program is missing,\n"
    "            70 our fault, 73 cannot create, 74 read or write failed, 75 try again";

// leaked: exceptions may still be translated while Python ends
PyObject* error_class = nullptr;

void raise_in_python(const Error& error) {
  const py::object instance = py::reinterpret_borrow<py::object>(error_class)(py::str(error.what()));
  instance.attr("where") = error.text().where;
  instance.attr("what") = error.text().what;
  instance.attr("value") = error.text().value;
  instance.attr("remedy") = error.text().remedy;
  instance.attr("exit_code") = exit_code_of(error.fault());
  PyErr_SetObject(error_class, instance.ptr());
}

}  // namespace

void bind_errors(py::module_& module) {
  error_class = PyErr_NewExceptionWithDoc("umax.Error", doc, PyExc_RuntimeError, nullptr);
  if (error_class == nullptr) throw py::error_already_set();
  module.attr("Error") = py::reinterpret_borrow<py::object>(error_class);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      raise_in_python(error);
    }
  });
}

}  // namespace umax
