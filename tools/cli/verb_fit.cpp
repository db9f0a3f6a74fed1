#include <fmt/format.h>

#include <filesystem>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "scenes/quantity.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"
#include "tools/fit/fit_folder.h"
#include "tools/fit/fit_report.h"

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

int fit(const Options& options) {
  if (options.inputs.size() != 1)
    throw Error(Fault::usage, {"umax fit", "takes one file of measurements", std::to_string(options.inputs.size()),
                               "give a .csv file; see umax help fit"});
  const std::filesystem::path file = options.inputs.front();
  const MeasurementOptions measured = measurement_options(options);
  const std::filesystem::path output = output_folder(options, file.stem().string() + "-fit");
  check_fit_folder(output, existing_folder(options));
  const Measurements measurements = parse_measurements(read_file(file), file.string(), measured);
  for (const std::string& warning : measurements.warnings) fmt::print(stderr, "umax: warning: {}\n", warning);

  const MaterialFit fit = fit_material(measurements, options.poisson.value_or(0.3));
  for (const std::string& warning : fit.warnings)
    fmt::print(stderr, "umax: warning: {}: {}\n", measurements.name, warning);
  const FitFolder folder(output, existing_folder(options));
  write_file(folder.plot(), fit_plot(measurements, fit));
  write_file(folder.snippet(), fit_snippet(measurements, fit));
  if (!options.quiet)
    fmt::print("{}\n{}{}", fit_table(measurements, fit), fit_snippet(measurements, fit),
               fmt::format("\nin {}: {}, {}\n", folder.path().string(), folder.snippet().filename().string(),
                           folder.plot().filename().string()));
  return 0;
}

}  // namespace

Verb fit_verb() {
  return {
      .name = "fit",
      .usage = "MEASUREMENTS.csv",
      .summary = "material and limit from force-deformation data",
      .details =
          "Simulates the test that was measured on hexes and adjusts Young's modulus, the limit and, where the data "
          "tell it, Poisson's ratio until the stretches at the measured forces fit. Writes DIR/material.toml, lines "
          "for a scene, and DIR/fit.svg with data, simulated test and residuals.\n\nThe file has comma-separated "
          "columns with a header: stretch [%] (change of length over length), stretch ratio (length over length) or "
          "displacement [mm]; force [N] or stress [kPa] (over the section at rest); lateral stretch [%] or lateral "
          "stretch ratio, if measured, tell Poisson's ratio. Lines that begin with # are comments.",
      .examples = {"umax fit silicone.csv --length \"50 mm\" --area \"24 mm^2\"",
                   "umax fit pads.csv --test shear --length \"4 mm\" --area \"10 cm^2\" --poisson 0.49"},
      .arguments = {.endings = {"csv"}, .folders = true},
      .options = {"--output", "--overwrite", "--test", "--length", "--area", "--poisson", "--quiet"},
      .run = fit};
}

}  // namespace umax
