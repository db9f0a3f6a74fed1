#include "tools/pictures/plot.h"

#include <cmath>
#include <limits>

#include "tests/support/catch.h"
#include "tests/tools/svg_paths.h"
#include "tools/pictures/plot_scale.h"

using namespace umax;

namespace {

constexpr const char* series_width = "1.4";
constexpr double resolution = 1.0 / 128;  // [px] Cairo's coordinates are 256ths

Plot plot_of(const std::vector<PlotSeries>& series) {
  Plot plot{.title = "title <&>", .panels = {PlotPanel{}}};
  plot.x.label = "time [s]";
  plot.panels[0].y.label = "force [N]";
  plot.panels[0].series = series;
  return plot;
}

/// The largest distance of pixels from the line through the first and the last pair of value and pixel.
double distance_from_linear(const std::vector<double>& values, const std::vector<double>& pixels) {
  REQUIRE(values.size() == pixels.size());
  const double slope = (pixels.back() - pixels.front()) / (values.back() - values.front());
  double largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    largest = std::max(largest, std::abs(pixels.front() + slope * (values[i] - values.front()) - pixels[i]));
  return largest;
}

std::vector<std::string> labels_of(const Scale& scale) {
  std::vector<std::string> labels;
  for (const Tick& tick : scale.ticks)
    if (!tick.label.empty()) labels.push_back(tick.label);
  return labels;
}

}  // namespace

TEST_CASE("a plot's line goes through its data") {
  PlotSeries series{.name = "parabola"};
  for (int i = 0; i <= 10; ++i) series.x.push_back(0.3 * i), series.y.push_back(0.7 * i * i - 20);
  const auto paths = svg_paths(draw_svg(plot_of({series})), series_width);
  REQUIRE(paths.size() == 1);
  CHECK(distance_from_linear(series.x, paths[0].x) < resolution);
  CHECK(distance_from_linear(series.y, paths[0].y) < resolution);
  CHECK(paths[0].x.back() > paths[0].x.front() + 500);
  CHECK(paths[0].y.back() < paths[0].y.front() - 150);  // up is less in SVG
}

TEST_CASE("a logarithmic axis has powers of ten at equal distances and leaves out what has no logarithm") {
  PlotSeries series{.name = "powers"};
  std::vector<double> exponents;
  for (int i = -6; i <= 3; ++i) series.x.push_back(i), series.y.push_back(std::pow(10.0, i)), exponents.push_back(i);
  Plot plot = plot_of({series});
  plot.panels[0].y.logarithmic = true;
  const auto paths = svg_paths(draw_svg(plot), series_width);
  REQUIRE(paths.size() == 1);
  CHECK(distance_from_linear(exponents, paths[0].y) < resolution);
  plot.panels[0].series[0].y[4] = 0;
  CHECK(svg_paths(draw_svg(plot), series_width).size() == 2);
}

TEST_CASE("a line of very many points is thinned and keeps its peaks") {
  PlotSeries noise{.name = "noise"}, peaks{.name = "peaks", .x = {0, 1}, .y = {50, -40}};
  constexpr int count = 200000;
  for (int i = 0; i < count; ++i) noise.x.push_back(double(i) / count), noise.y.push_back(std::sin(12.9898 * i));
  noise.y[123456] = 50;
  noise.y[654] = -40;
  const std::string svg = draw_svg(plot_of({noise, peaks}));
  CHECK(svg.size() < 150000);
  const auto paths = svg_paths(svg, series_width);
  REQUIRE(paths.size() == 2);
  const auto [top, foot] = std::minmax_element(paths[0].y.begin(), paths[0].y.end());
  CHECK(*top == paths[1].y[0]);
  CHECK(*foot == paths[1].y[1]);
  const double left = paths[1].x[0], right = paths[1].x[1];
  CHECK(std::abs(paths[0].x[std::size_t(top - paths[0].y.begin())] - (left + 0.61728 * (right - left))) < resolution);
  CHECK(paths[0].x.size() <= 4 * 720);
  CHECK(paths[0].x.size() > 2 * 600);
  CHECK(std::is_sorted(paths[0].x.begin(), paths[0].x.end()));
}

TEST_CASE("the same plot is the same file, whatever was drawn before") {
  const Plot plot = plot_of({{.name = "a", .x = {0, 1, 2}, .y = {3, 1, 2}}});
  const std::string first = draw_svg(plot);
  draw_svg(Plot{});
  CHECK(draw_svg(plot) == first);
}

TEST_CASE("a line has a gap where there is no number, and a lone point is seen") {
  const double none = std::nan(""), far = std::numeric_limits<double>::infinity();
  const PlotSeries series{.name = "a", .x = {0, 1, 2, 3, 4, 5, 6, 7}, .y = {1, 2, none, 1.5, far, 2, 1, 2}};
  const std::string svg = draw_svg(plot_of({series}));
  const auto paths = svg_paths(svg, series_width);
  REQUIRE(paths.size() == 2);
  CHECK(paths[0].x.size() == 2);
  CHECK(paths[1].x.size() == 3);
  PlotSeries without = series;
  without.y[3] = none;
  CHECK(svg.size() > draw_svg(plot_of({without})).size() + 100);
}

TEST_CASE("marks stand at their times, one for each column of pixels") {
  Plot plot = plot_of({{.name = "a", .x = {0, 1}, .y = {1, 2}}});
  const std::size_t before = svg_paths(draw_svg(plot)).size();
  plot.panels[0].marks = {.name = "bad", .x = {0.25, 0.5, 0.5 + 1e-9}};
  const auto paths = svg_paths(draw_svg(plot));
  const auto line = svg_paths(draw_svg(plot), series_width).at(0);
  CHECK(paths.size() == before + 2 + 2);  // the legend names both series then
  const auto is_at = [&](double share) {
    const double x = line.x[0] + share * (line.x[1] - line.x[0]);
    return std::count_if(paths.begin(), paths.end(), [&](const SvgPath& path) {
      return path.x.size() == 2 && std::abs(path.x[0] - x) < resolution && std::abs(path.y[0] - path.y[1]) == 9;
    });
  };
  CHECK(is_at(0.25) == 1);
  CHECK(is_at(0.5) == 1);
  CHECK(is_at(0.75) == 0);
}

TEST_CASE("plots of nothing, of one point and of extreme numbers are drawn") {
  const double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();
  for (const bool logarithmic : {false, true})
    for (const std::vector<double>& values : std::vector<std::vector<double>>{{},
                                                                              {0},
                                                                              {-3},
                                                                              {1e-12, 1e-12},
                                                                              {5, 5 + 1e-14},
                                                                              {huge, -huge, 1},
                                                                              {tiny, tiny},
                                                                              {0, tiny},
                                                                              {1e299, -1e299},
                                                                              {1e-299, 1e299},
                                                                              {-1e-200, 1e-200}}) {
      CAPTURE(logarithmic, values);
      Plot plot = plot_of({{.name = "a", .x = values, .y = values}});
      plot.x.logarithmic = plot.panels[0].y.logarithmic = logarithmic;
      std::string svg = draw_svg(plot);
      CHECK_NOTHROW(svg_paths(svg));
      CHECK(svg.find("nan") == std::string::npos);
      plot.panels[0].y.low = 0.5;
      plot.panels[0].y.whole_numbers = true;
      CHECK_NOTHROW(svg_paths(draw_svg(plot)));
    }
  CHECK_NOTHROW(svg_paths(draw_svg(Plot{})));
}

TEST_CASE("ticks are round numbers that cover the data") {
  using Labels = std::vector<std::string>;
  CHECK(labels_of(make_scale({}, 0.03, 1.001, 0, 1, 6, true)) ==
        Labels{"0.0", "0.2", "0.4", "0.6", "0.8", "1.0", "1.2"});
  CHECK(labels_of(make_scale({}, -7, 12, 0, 1, 4, true)) == Labels{"−10", "−5", "0", "5", "10", "15"});
  CHECK(labels_of(make_scale({.whole_numbers = true, .low = 0}, 0, 2, 0, 1, 6, true)) == Labels{"0", "1", "2"});
  CHECK(labels_of(make_scale({.low = -1.95, .high = 1.95}, 0, 0, 0, 1, 3, true)) == Labels{"−1", "0", "1"});
  CHECK(labels_of(make_scale({.logarithmic = true}, 3, 40, 0, 1, 6, true)) == Labels{"2", "5", "10", "20", "50"});
  CHECK(labels_of(make_scale({.logarithmic = true}, 2e-5, 1, 0, 1, 6, true)) ==
        Labels{"10⁻⁴", "0.001", "0.01", "0.1", "1"});
  const Scale large = make_scale({}, 0, 250000, 0, 1, 5, true);
  CHECK(large.exponent == 3);
  CHECK(labels_of(large) == Labels{"0", "50", "100", "150", "200", "250"});
  CHECK(large.at(0) == 0);
  CHECK(large.at(250000) == 1);
}
