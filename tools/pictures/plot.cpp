#include "tools/pictures/plot.h"

#include <cairo-svg.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>
#include <regex>

#include "core/base/error.h"
#include "tools/pictures/plot_scale.h"

namespace umax {
namespace {

constexpr const char* font = "DejaVu Sans";
// [px]
constexpr double width = 720, margin = 16, letter = 11.5, title_letter = 14, line_height = 19, tick_length = 4;

struct Color {
  double red, green, blue;
};
// Okabe and Ito's palette, which every kind of colour vision tells apart
constexpr std::array<Color, 6> series_colors{{{0, 0.447, 0.698},
                                              {0.902, 0.624, 0},
                                              {0, 0.62, 0.451},
                                              {0.2, 0.2, 0.2},
                                              {0.8, 0.475, 0.655},
                                              {0.337, 0.706, 0.914}}};
constexpr Color ink{0.15, 0.15, 0.15}, frame_gray{0.35, 0.35, 0.35}, grid_gray{0.89, 0.89, 0.89},
    level_color{0.15, 0.15, 0.15}, mark_red{0.85, 0.1, 0.1};

struct Point {
  double x, y;  // [px]
};

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double value, bool logarithmic) {
    if (!is_shown(value, logarithmic)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

Scale x_scale(const Plot& plot, double begin, double end) {
  Range range;
  for (const PlotPanel& panel : plot.panels) {
    for (const PlotSeries& series : panel.series)
      for (const double x : series.x) range.add(x, plot.x.logarithmic);
    for (const double x : panel.marks.x) range.add(x, plot.x.logarithmic);
  }
  return make_scale(plot.x, range.low, range.high, begin, end, 8, false);
}

Scale y_scale(const PlotPanel& panel) {
  Range range;
  for (const PlotSeries& series : panel.series)
    for (const double y : series.y) range.add(y, panel.y.logarithmic);
  for (const PlotLevel& level : panel.levels) range.add(level.y, panel.y.logarithmic);
  return make_scale(panel.y, range.low, range.high, panel.height, 0, std::max(2, int(panel.height / 40)), true);
}

/// The parts of a series between its gaps, in pixels.
std::vector<std::vector<Point>> parts_of(const PlotSeries& series, const Scale& x, const Scale& y) {
  assert(series.x.size() == series.y.size());
  std::vector<std::vector<Point>> parts(1);
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (is_shown(series.x[i], x.logarithmic) && is_shown(series.y[i], y.logarithmic))
      parts.back().push_back({x.at(series.x[i]), y.at(series.y[i])});
    else if (!parts.back().empty())
      parts.emplace_back();
  }
  return parts;
}

/// Of points that follow one another in one column of pixels: the first, the lowest, the highest and the last.
std::vector<Point> thinned(const std::vector<Point>& line) {
  const auto is_lower = [](const Point& a, const Point& b) { return a.y < b.y; };
  std::vector<Point> kept;
  for (auto begin = line.begin(); begin != line.end();) {
    const auto end =
        std::find_if(begin, line.end(), [&](const Point& p) { return std::floor(p.x) != std::floor(begin->x); });
    const auto [lowest, highest] = std::minmax_element(begin, end, is_lower);
    auto before = end;
    for (const auto point : {begin, std::min(lowest, highest), std::max(lowest, highest), end - 1}) {
      if (point != before) kept.push_back(*point);
      before = point;
    }
    begin = end;
  }
  return kept;
}

/// A Cairo page whose bytes become the SVG.
class Page {
 public:
  Page(double page_width, double height) {
    surface_.reset(cairo_svg_surface_create_for_stream(&Page::append, &text_, page_width, height));
    cairo_svg_surface_set_document_unit(surface_.get(), CAIRO_SVG_UNIT_PX);
    cairo_.reset(cairo_create(surface_.get()));
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(get(), options);
    cairo_font_options_destroy(options);
    cairo_select_font_face(get(), font, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_source_rgb(get(), 1, 1, 1);
    cairo_paint(get());
  }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  cairo_t* get() const { return cairo_.get(); }

  std::string finish() {
    cairo_surface_finish(surface_.get());
    if (cairo_status(get()) != CAIRO_STATUS_SUCCESS || cairo_surface_status(surface_.get()) != CAIRO_STATUS_SUCCESS)
      throw Error(Fault::internal, {.what = "a plot could not be drawn", .remedy = "please report it"});
    // the only thing that is not the plot's: the surface's number in this process
    static const std::regex surface_number("surface[0-9]+");
    return std::regex_replace(text_, surface_number, "surface");
  }

 private:
  static cairo_status_t append(void* text, const unsigned char* bytes, unsigned length) {
    static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), length);
    return CAIRO_STATUS_SUCCESS;
  }
  struct Free {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
  };
  std::string text_;  // outlives the surface, which writes to it
  std::unique_ptr<cairo_surface_t, Free> surface_;
  std::unique_ptr<cairo_t, Free> cairo_;
};

void use(cairo_t* cairo, const Color& color, double line_width = 1, bool dashed = false) {
  const double dashes[] = {5, 3};
  cairo_set_source_rgb(cairo, color.red, color.green, color.blue);
  cairo_set_line_width(cairo, line_width);
  cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);  // a miter would overstate the peaks
  cairo_set_dash(cairo, dashes, dashed ? 2 : 0, 0);
}

void draw_line(cairo_t* cairo, double x0, double y0, double x1, double y1) {
  cairo_move_to(cairo, x0, y0);
  cairo_line_to(cairo, x1, y1);
  cairo_stroke(cairo);
}

void draw_disc(cairo_t* cairo, const Point& point, double radius) {
  cairo_arc(cairo, point.x, point.y, radius, 0, 6.283185307179586);
  cairo_fill(cairo);
}

double text_width(cairo_t* cairo, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, text.c_str(), &extents);
  return extents.x_advance;
}

/// `align`: 0 the text begins at x, 0.5 is centred there, 1 ends there.
void write_text(cairo_t* cairo, const std::string& text, double x, double baseline, double align) {
  cairo_move_to(cairo, x - align * text_width(cairo, text), baseline);
  cairo_show_text(cairo, text.c_str());
}

enum class Sample { line, dashed, points, level, marks };

struct LegendEntry {
  std::string name;
  Sample sample;
  Color color;
  double x = 0;  // [px] from the panel's left edge
  int row = 0;
};

constexpr double sample_width = 20;

/// The entries of a panel, in rows no wider than `room`.
std::vector<LegendEntry> legend_of(cairo_t* cairo, const PlotPanel& panel, double room) {
  std::vector<LegendEntry> entries;
  const bool is_alone = panel.series.size() == 1 && panel.levels.empty() && panel.marks.x.empty();
  for (std::size_t i = 0; i < panel.series.size() && !is_alone; ++i)
    entries.push_back({panel.series[i].name, Sample(panel.series[i].style), series_colors[i % series_colors.size()]});
  for (const PlotLevel& level : panel.levels) entries.push_back({level.name, Sample::level, level_color});
  if (!panel.marks.x.empty()) entries.push_back({panel.marks.name, Sample::marks, mark_red});
  double x = 0;
  int row = 0;
  for (LegendEntry& entry : entries) {
    const double needed = sample_width + 6 + text_width(cairo, entry.name);
    if (x > 0 && x + needed > room) x = 0, ++row;
    entry.x = x, entry.row = row;
    x += needed + 18;
  }
  return entries;
}

void draw_sample(cairo_t* cairo, const LegendEntry& entry, double x, double y) {
  use(cairo, entry.color, entry.sample == Sample::level ? 1 : 1.6,
      entry.sample == Sample::dashed || entry.sample == Sample::level);
  if (entry.sample == Sample::points) return draw_disc(cairo, {x + sample_width / 2, y}, 2.5);
  if (entry.sample == Sample::marks) return draw_line(cairo, x + sample_width / 2, y - 4, x + sample_width / 2, y + 4);
  draw_line(cairo, x, y, x + sample_width, y);
}

void draw_series(cairo_t* cairo, const PlotSeries& series, const Color& color, const Scale& x, const Scale& y) {
  use(cairo, color, 1.4, series.style == PlotStyle::dashed);
  for (const std::vector<Point>& part : parts_of(series, x, y)) {
    if (series.style == PlotStyle::points || part.size() == 1) {
      for (const Point& point : part) draw_disc(cairo, point, 2.5);
      continue;
    }
    for (const Point& point : thinned(part)) cairo_line_to(cairo, point.x, point.y);
    cairo_stroke(cairo);
  }
}

void draw_marks(cairo_t* cairo, const PlotMarks& marks, const Scale& x, double foot) {
  use(cairo, mark_red, 1);
  double before = -1;
  for (const double value : marks.x) {
    if (!is_shown(value, x.logarithmic) || std::floor(x.at(value)) == before) continue;
    before = std::floor(x.at(value));
    draw_line(cairo, x.at(value), foot, x.at(value), foot - 9);
  }
}

void draw_grid(cairo_t* cairo, const Scale& x, const Scale& y) {
  use(cairo, grid_gray, 0.7);
  for (const Tick& tick : x.ticks) draw_line(cairo, x.at(tick.value), y.begin, x.at(tick.value), y.end);
  for (const Tick& tick : y.ticks) draw_line(cairo, x.begin, y.at(tick.value), x.end, y.at(tick.value));
}

void draw_axes(cairo_t* cairo, const Scale& x, const Scale& y) {
  use(cairo, frame_gray, 0.9);
  draw_line(cairo, x.begin, y.begin, x.end, y.begin);
  draw_line(cairo, x.begin, y.begin, x.begin, y.end);
  for (const Tick& tick : x.ticks)
    if (!tick.label.empty()) draw_line(cairo, x.at(tick.value), y.begin, x.at(tick.value), y.begin + tick_length);
  for (const Tick& tick : y.ticks)
    if (!tick.label.empty()) draw_line(cairo, x.begin - tick_length, y.at(tick.value), x.begin, y.at(tick.value));
  use(cairo, ink);
  for (const Tick& tick : y.ticks)
    write_text(cairo, tick.label, x.begin - tick_length - 4, y.at(tick.value) + 0.36 * letter, 1);
  if (y.exponent != 0) write_text(cairo, "×10" + superscript(y.exponent), x.begin - tick_length - 4, y.end - 12, 1);
}

void draw_panel(cairo_t* cairo, const PlotPanel& panel, const Scale& x, const Scale& y) {
  draw_grid(cairo, x, y);
  cairo_save(cairo);
  cairo_rectangle(cairo, x.begin, y.end - 3, x.end - x.begin + 3, y.begin - y.end + 6);
  cairo_clip(cairo);
  for (std::size_t i = 0; i < panel.series.size(); ++i)
    draw_series(cairo, panel.series[i], series_colors[i % series_colors.size()], x, y);
  // over the series, which may fill the panel
  use(cairo, level_color, 1, true);
  for (const PlotLevel& level : panel.levels)
    if (is_shown(level.y, y.logarithmic)) draw_line(cairo, x.begin, y.at(level.y), x.end, y.at(level.y));
  draw_marks(cairo, panel.marks, x, y.begin);
  cairo_restore(cairo);
  draw_axes(cairo, x, y);

  // the axis's name, from below upwards
  cairo_save(cairo);
  cairo_translate(cairo, margin + 0.8 * letter, 0.5 * (y.begin + y.end));
  cairo_rotate(cairo, -1.5707963267948966);
  write_text(cairo, panel.y.label, 0, 0, 0.5);
  cairo_restore(cairo);
}

/// A panel with all that its place on the page depends on.
struct PlacedPanel {
  const PlotPanel* panel;
  Scale y;
  std::vector<LegendEntry> legend;
  double top = 0;  // [px] of its legend
};

void draw_legend(cairo_t* cairo, const PlacedPanel& placed, double left) {
  for (const LegendEntry& entry : placed.legend) {
    const double middle = placed.top + (entry.row + 0.5) * line_height;
    draw_sample(cairo, entry, left + entry.x, middle);
    use(cairo, ink);
    write_text(cairo, entry.name, left + entry.x + sample_width + 6, middle + 0.36 * letter, 0);
  }
}

}  // namespace

std::string draw_svg(const Plot& plot) {
  // sizes of texts first: the page's height and the panels' left edge depend on them
  Page measure(1, 1);
  cairo_set_font_size(measure.get(), letter);
  std::vector<PlacedPanel> panels;
  double label_width = 0, height = margin + (plot.title.empty() ? 0 : title_letter + 6);
  for (const PlotPanel& panel : plot.panels) {
    panels.push_back({&panel, y_scale(panel), legend_of(measure.get(), panel, 0.82 * width), height});
    PlacedPanel& placed = panels.back();
    for (const Tick& tick : placed.y.ticks) label_width = std::max(label_width, text_width(measure.get(), tick.label));
    const double above = placed.legend.empty() ? line_height : (placed.legend.back().row + 1) * line_height + 5;
    placed.y.end += height + above;
    placed.y.begin += height + above;
    height = placed.y.begin + margin;
  }
  const double left = std::round(margin + letter + 10 + label_width + tick_length + 4);
  const Scale x = x_scale(plot, left, width - 1.5 * margin);
  const double foot = panels.empty() ? height : panels.back().y.begin;
  Page page(width, std::ceil(foot + 3.2 * letter + margin));
  cairo_t* cairo = page.get();
  use(cairo, ink);
  cairo_set_font_size(cairo, title_letter);
  write_text(cairo, plot.title, left, margin + 0.7 * title_letter, 0);
  cairo_set_font_size(cairo, letter);
  for (const PlacedPanel& placed : panels) {
    draw_panel(cairo, *placed.panel, x, placed.y);
    draw_legend(cairo, placed, left);
  }
  use(cairo, ink);
  for (const Tick& tick : x.ticks)
    write_text(cairo, tick.label, x.at(tick.value), foot + tick_length + 1.2 * letter, 0.5);
  const std::string unit = x.exponent != 0 ? " × 10" + superscript(x.exponent) : "";
  write_text(cairo, plot.x.label + unit, 0.5 * (x.begin + x.end), foot + 3.2 * letter, 0.5);
  return page.finish();
}

}  // namespace umax
