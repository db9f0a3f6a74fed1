// The Python module umax._umax; umax/__init__.py gives its names to the package.
#include <pybind11/pybind11.h>

#include "tools/python/bindings.h"
#include "tools/system/version.h"

PYBIND11_MODULE(_umax, module) {
  module.doc() = "Soft bodies that stop deforming exactly where you say. See help(umax).";
  module.attr("__version__") = umax::version_text();
  umax::bind_errors(module);
  umax::bind_scene(module);
  umax::bind_simulation(module);
  umax::bind_runs(module);
  umax::bind_pictures(module);
  umax::bind_fit(module);
}
