#include <fmt/format.h>

#include <filesystem>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "scenes/quantity.h"
#include "tools/cli/verbs.h"
#include "tools/fit/fit_folder.h"
#include "tools/fit/fit_report.h"
#include "tools/run/job.h"

namespace umax {
namespace {

/// A quantity of an option; throws Error (usage) unless it is one and positive.
std::optional<double> positive_option(const std::optional<std::string>& text, const std::string& option,
                                      const Unit& unit) {
  if (!text) return std::nullopt;
  std::string problem;
  const auto quantity = parse_quantity(*text, unit, problem);
  if (quantity && quantity->value > 0) return quantity->value;
  throw Error(Fault::usage, {option, quantity ? "must be positive" : problem, *text,
                             fmt::format("give it as in {} \"{}\"", option, unit.example)});
}

MeasurementOptions measurement_options(const Options& options) {
  MeasurementOptions measured;
  if (options.test == "compression") measured.test = TestKind::compression;
  if (options.test == "shear") measured.test = TestKind::shear;
  measured.length = positive_option(options.length, "--length", units::length);
  measured.area = positive_option(options.area, "--area", units::area);
  return measured;
}

}  // namespace

int verb_fit(const Options& options) {
  if (options.inputs.size() != 1)
    throw Error(Fault::usage, {"umax fit", "takes one file of measurements", std::to_string(options.inputs.size()),
                               "give a .csv file; see umax help fit"});
  const std::filesystem::path file = options.inputs.front();
  const MeasurementOptions measured = measurement_options(options);
  const std::filesystem::path output = output_folder(options, file.stem().string() + "-fit");
  check_fit_folder(output, options.existing_folder());
  const Measurements measurements = parse_measurements(read_file(file), file.string(), measured);
  for (const std::string& warning : measurements.warnings) fmt::print(stderr, "umax: warning: {}\n", warning);

  const MaterialFit fit = fit_material(measurements, options.poisson.value_or(0.3));
  for (const std::string& warning : fit.warnings)
    fmt::print(stderr, "umax: warning: {}: {}\n", measurements.name, warning);
  const FitFolder folder(output, options.existing_folder());
  write_file(folder.plot(), fit_plot(measurements, fit));
  write_file(folder.snippet(), fit_snippet(measurements, fit));
  if (!options.quiet)
    fmt::print("{}\n{}{}", fit_table(measurements, fit), fit_snippet(measurements, fit),
               fmt::format("\nin {}: {}, {}\n", folder.path().string(), folder.snippet().filename().string(),
                           folder.plot().filename().string()));
  return 0;
}

}  // namespace umax
