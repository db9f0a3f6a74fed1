#include "tools/run/step_plots.h"

#include <algorithm>
#include <cmath>

#include "scenes/scene.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/svg_paths.h"
#include "tools/run/run_folder.h"
#include "tools/run/steps_csv.h"

using namespace umax;

namespace {

StepRow row(int step) {
  StepRow row{
      .step = step, .frame = step + 1, .time = 0.01 * step, .hexes = 8, .report = {}, .wall_ms = 2, .probes = {}};
  row.report.max_energy_ratio = std::min(1.0005, 0.02 * step);
  row.report.contacts = std::abs(step % 40 - 20);
  row.report.limits_active = step / 50;
  row.report.kinetic_energy = step;
  row.report.elastic_energy = 0.5 * step;
  row.report.potential_energy = 300 - 3 * step;
  if (step % 30 == 0) row.report.status = StepStatus::iteration_limit;
  return row;
}

/// [px] height of a line at x. Cairo leaves out points that lie on the line between their neighbours.
double height_at(const SvgPath& path, double x) {
  std::size_t i = 1;
  while (i + 1 < path.x.size() && path.x[i] < x) ++i;
  return path.y[i - 1] + (path.y[i] - path.y[i - 1]) * (x - path.x[i - 1]) / (path.x[i] - path.x[i - 1]);
}

/// [px] how far a line strays from values at equal distances of time; the lowest and highest set the scale.
double largest_error(const SvgPath& path, const std::vector<double>& values) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < values.size(); ++i)
    heights.push_back(
        height_at(path, path.x.front() + (path.x.back() - path.x.front()) * double(i) / double(values.size() - 1)));
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double foot = heights[std::size_t(low - values.begin())], top = heights[std::size_t(high - values.begin())];
  CHECK(foot - top > 50);
  double largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    largest = std::max(largest, std::abs(foot + (values[i] - *low) / (*high - *low) * (top - foot) - heights[i]));
  return largest;
}

}  // namespace

TEST_CASE("the plots of a run show the columns of its steps.csv") {
  const TemporaryFolder temporary;
  const RunFolder folder(temporary / "run", ExistingFolder::refuse);
  constexpr int count = 100;
  std::vector<double> ratio, kinetic, total, contacts, limits;
  {
    StepsFile file(folder.steps(), steps_header({}), 0);
    for (int step = 1; step <= count; ++step) {
      file.append({row(step)});
      const StepReport report = row(step).report;
      ratio.push_back(report.max_energy_ratio);
      kinetic.push_back(report.kinetic_energy);
      total.push_back(report.kinetic_energy + report.elastic_energy + report.potential_energy);
      contacts.push_back(report.contacts);
      limits.push_back(report.limits_active);
    }
  }
  Scene scene;
  scene.name = "test";
  write_step_plots(folder, scene);
  const auto lines = [&](const std::string& name) { return svg_paths(file_text(folder.plots() / name), "1.4"); };

  const auto energies = lines("energies.svg");
  REQUIRE(energies.size() == 4);
  CHECK(largest_error(energies[0], kinetic) < 0.01);
  CHECK(largest_error(energies[3], total) < 0.01);
  CHECK(energies[3].style.find("dash") != std::string::npos);
  // 1 J is as high in each of them
  CHECK(energies[0].y.front() - energies[0].y.back() ==
        Approx((energies[2].y.back() - energies[2].y.front()) / 3).epsilon(1e-3));

  const auto ratios = lines("max_energy_ratio.svg");
  REQUIRE(ratios.size() == 2);  // the whole, and the limit's surroundings
  CHECK(largest_error(ratios[0], ratio) < 0.01);
  CHECK(largest_error(lines("contacts.svg").at(0), contacts) < 0.01);
  CHECK(largest_error(lines("limits_active.svg").at(0), limits) < 0.01);
  CHECK(lines("wall_ms.svg").size() == 1);

  // steps 30, 60 and 90 are marked
  const auto x_of = [&](int step) {
    return ratios[0].x.front() + (ratios[0].x.back() - ratios[0].x.front()) * (step - 1) / (count - 1);
  };
  int marks = 0;
  for (const SvgPath& path : svg_paths(file_text(folder.plots() / "max_energy_ratio.svg")))
    for (const int step : {30, 60, 90})
      marks += path.x.size() == 2 && std::abs(path.x[0] - x_of(step)) < 0.01 && std::abs(path.y[0] - path.y[1]) == 9;
  CHECK(marks == 3);
}
