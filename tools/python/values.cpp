// Python's values as TOML, and back.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/base/overloaded.h"
#include "tools/python/bindings.h"

namespace py = pybind11;

namespace umax {
namespace {

// A key may have dots, as --set has them; what TOML does not take bare is quoted.
std::string toml_key(const std::string& key) {
  const bool is_bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.';
  });
  return is_bare ? key : toml_string(key);
}

std::string list_of(const std::string& key, const py::handle& sequence) {
  std::string text;
  for (const py::handle element : sequence) text += (text.empty() ? "" : ", ") + toml_value(key, element);
  return "[" + text + "]";
}

std::string inline_table(const std::string& key, const py::dict& table) {
  std::string text;
  for (const auto& [name, value] : table)
    text += (text.empty() ? "" : ", ") + toml_key(py::str(name)) + " = " + toml_value(key, value);
  return "{ " + text + " }";
}

void add_lines(const std::string& start, const py::dict& table, std::string& lines) {
  for (const auto& [name, value] : table) {
    const std::string key = start + toml_key(py::str(name));
    if (py::isinstance<py::dict>(value) && py::len(value) > 0)
      add_lines(key + ".", py::reinterpret_borrow<py::dict>(value), lines);
    else
      lines += key + " = " + toml_value(key, value) + "\n";
  }
}

}  // namespace

std::string toml_value(const std::string& key, const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
  if (py::isinstance<py::int_>(value)) return py::str(value);
  if (py::isinstance<py::float_>(value)) return py::repr(py::float_(py::reinterpret_borrow<py::object>(value)));
  if (py::isinstance<py::str>(value)) return toml_string(value.cast<std::string>());
  if (py::isinstance<py::dict>(value)) return inline_table(key, py::reinterpret_borrow<py::dict>(value));
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value)) return list_of(key, value);
  if (py::hasattr(value, "tolist")) return toml_value(key, value.attr("tolist")());  // numpy's
  if (py::hasattr(value, "__fspath__")) return toml_string(value.attr("__fspath__")().cast<std::string>());
  throw Error(Fault::bad_data, {.where = key_in_script(key),
                                .what = "cannot be written into a scene",
                                .value = py::repr(value),
                                .remedy = "give a number, a string such as \"15 %\", a bool, a list or a dict"});
}

std::string toml_document(const py::handle& dict) {
  std::string lines;
  add_lines("", py::reinterpret_borrow<py::dict>(dict), lines);
  return lines;
}

py::object python_value(const SceneValue& value) {
  const Overloaded convert{[](const SceneValue::Date&) -> py::object { return py::none(); },
                           [](const SceneValue::Array& array) -> py::object {
                             py::list list;
                             for (const SceneValue& element : array) list.append(python_value(element));
                             return list;
                           },
                           [](const SceneValue::Table& table) -> py::object {
                             py::dict dict;
                             for (const auto& [name, element] : table) dict[py::str(name)] = python_value(element);
                             return dict;
                           },
                           [](const auto& plain) -> py::object { return py::cast(plain); }};
  return std::visit(convert, value.data);
}

}  // namespace umax
