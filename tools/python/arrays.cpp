// numpy's arrays: copies, views and what is read of them.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "tools/python/bindings.h"

namespace py = pybind11;

namespace umax {
namespace {

template <class Number>
py::array copy_of(const std::vector<py::ssize_t>& shape, const Number* numbers) {
  return py::array_t<Number>(shape, numbers);
}

std::string shape_text(const py::array& array) {
  return py::str(array.attr("shape"));
}

[[noreturn]] void refuse(const std::string& what, const std::string& is, const std::string& value,
                         const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = what, .what = is, .value = value, .remedy = remedy});
}

py::array array_from(const py::handle& object, const std::string& what) {
  py::array array = py::array::ensure(py::reinterpret_borrow<py::object>(object));
  if (array && (array.dtype().kind() == 'f' || array.dtype().kind() == 'i' || array.dtype().kind() == 'u'))
    return array;
  PyErr_Clear();
  refuse(what, "is no array of numbers", py::str(py::type::of(object)), "give a numpy array of floats");
}

}  // namespace

py::object array_of(const Points& points) {
  return copy_of({points.rows(), 3}, points.data());
}
py::object array_of(const Triangles& triangles) {
  return copy_of({triangles.rows(), 3}, triangles.data());
}
py::object array_of(const VectorXd& vector) {
  return copy_of({vector.size()}, vector.data());
}
py::object array_of(const Image& image) {
  return copy_of({image.height, image.width, image.channels}, image.values.data());
}
py::object array_of(const Image8& image) {
  return copy_of({image.height, image.width, image.channels}, image.values.data());
}

py::object view_of(const std::shared_ptr<const Points>& points) {
  using Holder = std::shared_ptr<const Points>;
  const py::capsule owner(new Holder(points), [](void* holder) { delete static_cast<Holder*>(holder); });
  py::array_t<double> view({points->rows(), Eigen::Index(3)}, points->data(), owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

Points points_from(const py::handle& object, const std::string& what, Eigen::Index rows) {
  const py::array array = array_from(object, what);
  if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != 3)
    refuse(what, "must have the shape (" + std::to_string(rows) + ", 3)", shape_text(array),
           "give one row of x, y, z for each node, or of a surface for each vertex");
  const auto numbers = py::array_t < double, py::array::c_style | py::array::forcecast > ::ensure(array);
  if (!numbers) throw py::error_already_set();
  Points points = Eigen::Map<const Points>(numbers.data(), rows, 3);
  if (!points.allFinite()) refuse(what, "must be finite", "infinity or NaN", "look at what it is computed from");
  return points;
}

Image8 image_from(const py::handle& object, const std::string& what) {
  const py::array array = array_from(object, what);
  const bool is_grey = array.ndim() == 2;
  const py::ssize_t channels = is_grey ? 1 : array.ndim() == 3 ? array.shape(2) : 0;
  if (channels != 1 && channels != 3 && channels != 4)
    refuse(what, "must have the shape (height, width, channels) with 1, 3 or 4 channels", shape_text(array),
           "give a picture");
  Image8 image(int(array.shape(1)), int(array.shape(0)), int(channels));
  if (array.dtype().is(py::dtype::of<std::uint8_t>())) {
    const auto bytes = py::array_t < std::uint8_t, py::array::c_style | py::array::forcecast > ::ensure(array);
    std::copy_n(bytes.data(), image.values.size(), image.values.begin());
    return image;
  }
  if (array.dtype().kind() != 'f')
    refuse(what, "must be of uint8, or of floats in [0, 1]", py::str(array.dtype()), "convert it with astype");
  const auto floats = py::array_t < double, py::array::c_style | py::array::forcecast > ::ensure(array);
  std::transform(floats.data(), floats.data() + floats.size(), image.values.begin(), [&](double value) {
    if (std::isnan(value)) refuse(what, "must be finite", "NaN", "look at what it is computed from");
    return std::uint8_t(std::lround(255 * std::clamp(value, 0.0, 1.0)));
  });
  return image;
}

}  // namespace umax
