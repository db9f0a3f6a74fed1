// umax.fit: materials from measurements.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "scenes/quantity.h"
#include "tools/fit/fit_report.h"
#include "tools/python/bindings.h"

namespace py = pybind11;

namespace umax {
namespace {

constexpr const char* fit_doc =
    "fit(measurements, *, test='uniaxial', length=None, area=None, poisson=0.3) -> Fit\n\n"
    "umax fit: Young's modulus, the limit and, where the data tell it, Poisson's ratio of a measured specimen.\n\n"
    "measurements:  path of a .csv file, or a dict of columns by title: {'stretch [%]': [...], 'stress [kPa]': [...]}\n"
    "test:          'uniaxial', 'compression' or 'shear'\n"
    "length, area:  of the specimen at rest, in metres and square metres or as '50 mm', '24 mm^2'; where displacements "
    "or\n"
    "               forces were measured\n"
    "poisson:       taken where no lateral stretch was measured\n\n"
    "Raises umax.Error for data that cannot be read or do not tell Young's modulus; warns of what was ignored.";

struct FitResult {
  Measurements measurements;
  MaterialFit fit;
};

std::optional<double> quantity_from(const py::object& value, const char* name, const Unit& unit) {
  if (value.is_none()) return std::nullopt;
  const std::string text = py::str(value);
  std::string problem;
  const auto quantity = parse_quantity(text, unit, problem);
  if (quantity && quantity->value > 0) return quantity->value;
  throw Error(Fault::bad_data, {.where = name,
                                .what = quantity ? "must be positive" : problem,
                                .value = text,
                                .remedy = fmt::format("give it as in \"{}\"", unit.example)});
}

/// Columns as the text of a table.
std::string table_from(const py::dict& columns) {
  std::string header;
  std::vector<py::list> lists;
  for (const auto& [title, values] : columns) {
    header += (header.empty() ? "\"" : ",\"") + std::string(py::str(title)) + "\"";
    lists.emplace_back(py::reinterpret_borrow<py::object>(values));
    if (lists.back().size() != lists.front().size())
      throw Error(Fault::bad_data, {.where = py::str(title),
                                    .what = "has another length than the first column",
                                    .value = std::to_string(lists.back().size()),
                                    .remedy = "give columns of one length"});
  }
  std::string text = header + "\n";
  for (std::size_t row = 0; !lists.empty() && row < lists.front().size(); ++row)
    for (std::size_t column = 0; column < lists.size(); ++column)
      text +=
          std::string(py::repr(py::float_(py::object(lists[column][row])))) + (column + 1 < lists.size() ? "," : "\n");
  return text;
}

TestKind kind_of_test(const std::string& test) {
  for (const TestKind kind : {TestKind::uniaxial, TestKind::compression, TestKind::shear})
    if (test == test_name(kind)) return kind;
  throw Error(Fault::bad_data, {.where = "test",
                                .what = "is no test that can be fitted",
                                .value = test,
                                .remedy = "give \"uniaxial\", \"compression\" or \"shear\""});
}

FitResult fit(const py::object& measurements, const std::string& test, const py::object& length, const py::object& area,
              double poisson) {
  const MeasurementOptions options{.test = kind_of_test(test),
                                   .length = quantity_from(length, "length", units::length),
                                   .area = quantity_from(area, "area", units::area)};
  const bool is_table = py::isinstance<py::dict>(measurements);
  const std::string name = is_table ? "measurements" : std::string(py::str(measurements));
  const std::string text = is_table ? table_from(measurements) : read_file(name);
  FitResult result{parse_measurements(text, name, options), {}};
  long_call([&] { result.fit = fit_material(result.measurements, poisson); });
  for (const std::string& warning : result.measurements.warnings) warn(warning);
  for (const std::string& warning : result.fit.warnings) warn(warning);
  return result;
}

py::object interval(const Estimate& estimate) {
  return py::make_tuple(estimate.low, estimate.high);
}

py::object value_or_none(const std::optional<Estimate>& estimate) {
  return estimate ? py::object(py::float_(estimate->value)) : py::none();
}

py::object interval_or_none(const std::optional<Estimate>& estimate) {
  return estimate ? interval(*estimate) : py::none();
}

}  // namespace

void bind_fit(py::module_& module) {
  py::class_<FitResult>(module, "Fit", "A material from measurements. Intervals: (low, high), 95 % confidence.")
      .def_property_readonly(
          "young", [](const FitResult& r) { return r.fit.young.value; }, "[Pa]")
      .def_property_readonly(
          "young_interval", [](const FitResult& r) { return interval(r.fit.young); }, "[Pa]")
      .def_property_readonly(
          "limit", [](const FitResult& r) { return value_or_none(r.fit.limit); },
          "[-] limit.stretch; None where the data do not reach one.")
      .def_property_readonly(
          "limit_interval", [](const FitResult& r) { return interval_or_none(r.fit.limit); },
          "[-] None where the data do not reach a limit.")
      .def_property_readonly(
          "poisson", [](const FitResult& r) { return r.fit.used_poisson(); }, "[-] fitted, or what was assumed.")
      .def_property_readonly(
          "poisson_interval", [](const FitResult& r) { return interval_or_none(r.fit.poisson); },
          "[-] None where the data do not tell it.")
      .def_property_readonly(
          "rms", [](const FitResult& r) { return r.fit.rms; }, "[-] of stretch measured less simulated.")
      .def_property_readonly(
          "toml", [](const FitResult& r) { return fit_snippet(r.measurements, r.fit); },
          "Lines to go below a scene's [body.NAME].")
      .def("__repr__", [](const FitResult& r) {
        const std::string limit = r.fit.limit ? fmt::format(", limit {:.3g} %", 100 * r.fit.limit->value) : "";
        return fmt::format("<umax.Fit young {:.4g} Pa{}, rms {:.2g}>", r.fit.young.value, limit, r.fit.rms);
      });
  module.def("fit", &fit, py::arg("measurements"), py::kw_only(), py::arg("test") = "uniaxial",
             py::arg("length") = py::none(), py::arg("area") = py::none(), py::arg("poisson") = 0.3, fit_doc);
}

}  // namespace umax
