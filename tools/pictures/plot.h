// Line plots as SVG: panels over one another on a common horizontal axis, with ticks, a light grid and legends.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace umax {

struct PlotAxis {
  std::string label{};                  // with its unit: "energy [J]"
  bool logarithmic = false;             // values <= 0 are left out
  bool whole_numbers = false;           // of counts: no tick between them
  std::optional<double> low{}, high{};  // ends; unset: the data's
};

enum class PlotStyle { line, dashed, points };

/// A curve or a cloud of points; a line has a gap where x or y is not finite.
struct PlotSeries {
  std::string name{};            // in the legend
  std::vector<double> x{}, y{};  // as many of both
  PlotStyle style = PlotStyle::line;
};

/// A horizontal line across a panel.
struct PlotLevel {
  std::string name{};  // in the legend
  double y = 0;
};

/// Short red ticks at the foot of a panel.
struct PlotMarks {
  std::string name{};  // in the legend
  std::vector<double> x{};
};

struct PlotPanel {
  PlotAxis y{};
  std::vector<PlotSeries> series{};
  std::vector<PlotLevel> levels{};
  PlotMarks marks{};
  double height = 280;  // [px] of the data's area
};

struct Plot {
  std::string title{};
  PlotAxis x{};
  std::vector<PlotPanel> panels{};
};

/// The plot as an SVG file: the same bytes for the same plot. Lines of many points are thinned to the first, lowest,
/// highest and last of each column of pixels. A series that is all there is to see in its panel is not in the legend.
std::string draw_svg(const Plot& plot);

}  // namespace umax
