#include "tools/fit/fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "tools/pictures/plot.h"

namespace umax {
namespace {

struct PressureUnit {
  double pascals;
  const char* symbol;
};

PressureUnit unit_for(double pressure) {
  if (pressure >= 1e9) return {1e9, "GPa"};
  if (pressure >= 1e6) return {1e6, "MPa"};
  if (pressure >= 1e3) return {1e3, "kPa"};
  return {1, "Pa"};
}

/// Decimals that show four digits of the value, and no fewer than two of its interval.
int decimals_for(double value, double interval) {
  int decimals = 3 - int(std::floor(std::log10(std::max(std::abs(value), 1e-12))));
  if (interval > 0 && std::isfinite(interval)) decimals = std::min(decimals, 1 - int(std::floor(std::log10(interval))));
  return std::clamp(decimals, 0, 9);
}

std::string number(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "∞";
}

struct Row {
  std::string value, range;  // "868 kPa", "820 … 915 kPa"
};

Row row_of(const Estimate& estimate, double factor, const std::string& unit) {
  const int decimals = decimals_for(estimate.value * factor, (estimate.high - estimate.low) * factor / 2);
  return {number(estimate.value * factor, decimals) + unit,
          number(estimate.low * factor, decimals) + " … " + number(estimate.high * factor, decimals) + unit};
}

Row young_row(const MaterialFit& fit) {
  const PressureUnit unit = unit_for(fit.young.value);
  return row_of(fit.young, 1 / unit.pascals, std::string(" ") + unit.symbol);
}
Row limit_row(const MaterialFit& fit) {
  return row_of(*fit.limit, 100, " %");
}

std::string bound_text(const MaterialFit& fit) {
  return number(100 * fit.limit_bound, std::max(0, decimals_for(100 * fit.limit_bound, 0) - 1)) + " %";
}

std::string file_name(const Measurements& data) {
  return std::filesystem::path(data.name).filename().string();
}

std::string line(const std::string& name, const std::string& value, const std::string& note) {
  return fmt::format("  {:<18} {:<16} {}\n", name, value, note);
}

/// Compression is shown by its amounts.
double shown(const Measurements& data, double value) {
  return data.test == TestKind::compression ? -value : value;
}

const char* stretch_label(TestKind test) {
  return test == TestKind::shear ? "shear [%]" : test == TestKind::compression ? "compression [%]" : "stretch [%]";
}

PlotSeries series(const std::string& name, PlotStyle style) {
  return {.name = name, .x = {}, .y = {}, .style = style};
}

/// The simulated specimen at many forces; its stress in the unit.
PlotSeries simulated_series(const Measurements& data, const MaterialFit& fit, const PressureUnit& unit) {
  constexpr int count = 400;
  double low = 0, high = 0;
  for (const MeasuredPoint& point : data.points) low = std::min(low, point.stress), high = std::max(high, point.stress);
  std::vector<double> stresses;
  for (int i = 0; i <= count; ++i) stresses.push_back(low + (high - low) * i / count);
  const double limit = fit.limit ? fit.limit->value : std::numeric_limits<double>::infinity();
  const SimulatedTest test = simulate_test(data.test, fit.young.value, fit.used_poisson(), limit, stresses);
  PlotSeries simulated = series("simulated hexes", PlotStyle::line);
  for (std::size_t i = 0; i < stresses.size(); ++i) {
    simulated.x.push_back(shown(data, stresses[i]) / unit.pascals);
    simulated.y.push_back(100 * shown(data, test.stretch[i]));
  }
  return simulated;
}

}  // namespace

std::string fit_table(const Measurements& data, const MaterialFit& fit) {
  std::string text = fmt::format("{}: {} test, {} rows{}\n\n", data.name, test_name(data.test), data.points.size(),
                                 fit.limit ? fmt::format(", {} of them at the limit", fit.points_at_limit) : "");
  if (!data.reading.empty()) text.insert(text.size() - 1, fmt::format("  read {}\n", data.reading));
  text += line("", "value", "95 % interval");
  const Row young = young_row(fit);
  text += line("Young's modulus", young.value, young.range);
  if (data.test == TestKind::shear) {
    const double factor = 1 / (2 * (1 + fit.used_poisson()));
    const Estimate modulus{fit.young.value * factor, fit.young.low * factor, fit.young.high * factor};
    const PressureUnit unit = unit_for(modulus.value);
    const Row row = row_of(modulus, 1 / unit.pascals, std::string(" ") + unit.symbol);
    text += line("shear modulus", row.value, row.range);
  }
  if (fit.limit) {
    const Row limit = limit_row(fit);
    text += line("limit.stretch", limit.value, limit.range);
  } else {
    text += line("limit.stretch", "≥ " + bound_text(fit), "no row reaches a limit; one-sided, 95 %");
  }
  if (fit.poisson) {
    const Row poisson = row_of(*fit.poisson, 1, "");
    text += line("Poisson's ratio", poisson.value, poisson.range);
  } else {
    text += line("Poisson's ratio", fmt::format("{:g}", fit.assumed_poisson),
                 data.test == TestKind::shear ? "assumed (--poisson); the shear modulus does not depend on it"
                                              : "assumed (--poisson): a column of lateral stretch would tell it");
  }
  const MeasuredPoint& worst = data.points[fit.worst];
  text += fmt::format(
      "\n  misfit: {:.2g} % of stretch (root mean square); most in line {}, {:.3g} % where {:.3g} % fits\n",
      100 * fit.rms, worst.line, 100 * shown(data, worst.stretch), 100 * shown(data, fit.stretch[fit.worst]));
  return text;
}

std::string fit_snippet(const Measurements& data, const MaterialFit& fit) {
  const Row young = young_row(fit);
  std::string text = fmt::format("{}{} ({} test, {} rows); put it below a [body.NAME]\n", snippet_beginning,
                                 file_name(data), test_name(data.test), data.points.size());
  text += fmt::format("material.young = \"{}\"  # 95 %: {}\n", young.value, young.range);
  if (fit.poisson)
    text += fmt::format("material.poisson = {}  # 95 %: {}\n", row_of(*fit.poisson, 1, "").value,
                        row_of(*fit.poisson, 1, "").range);
  else if (data.test == TestKind::shear)
    text += fmt::format("material.poisson = {:g}  # assumed; what was measured is the shear modulus\n",
                        fit.assumed_poisson);
  if (fit.limit)
    text += fmt::format("limit.stretch = \"{}\"  # 95 %: {}\n", limit_row(fit).value, limit_row(fit).range);
  else
    text += fmt::format("# limit.stretch: no row reaches a limit; it is at least {} (95 %)\n", bound_text(fit));
  return text;
}

std::string fit_plot(const Measurements& data, const MaterialFit& fit) {
  double largest = 0;
  for (const MeasuredPoint& point : data.points) largest = std::max(largest, std::abs(point.stress));
  const PressureUnit unit = unit_for(largest);
  PlotSeries measured = series("measured", PlotStyle::points),
             residuals = series("measured less simulated", PlotStyle::points);
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    const MeasuredPoint& point = data.points[i];
    measured.x.push_back(shown(data, point.stress) / unit.pascals);
    measured.y.push_back(100 * shown(data, point.stretch));
    residuals.y.push_back(100 * (shown(data, point.stretch) - shown(data, fit.stretch[i])));
  }
  residuals.x = measured.x;

  PlotPanel curve;
  curve.y.label = stretch_label(data.test);
  curve.series = {simulated_series(data, fit, unit), measured};
  if (fit.limit && data.test != TestKind::shear)
    curve.levels = {{"limit.stretch = " + limit_row(fit).value, 100 * fit.limit->value}};
  PlotPanel misfit;
  misfit.y.label = "residual [%]";
  misfit.series = {residuals};
  misfit.levels = {{"simulated", 0}};
  misfit.height = 130;
  Plot plot;
  plot.title = fmt::format("{}: Young's modulus {}", file_name(data), young_row(fit).value);
  plot.panels = {curve, misfit};
  plot.x.label = fmt::format("nominal stress [{}]", unit.symbol);
  return draw_svg(plot);
}

}  // namespace umax
