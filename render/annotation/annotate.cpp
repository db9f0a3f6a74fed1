#include "render/annotation/annotate.h"

#include <cairo.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <memory>

#include "render/image/colormap.h"

namespace umax {
namespace {

constexpr const char* font = "DejaVu Sans";  // where missing, Cairo takes another

/// Puts what is drawn, premultiplied with its own alpha, over a pixel whose alpha is straight.
void blend_over(std::uint32_t drawn, std::uint8_t* codes) {
  const float alpha = float(drawn >> 24) / 255, below = (1 - alpha) * float(codes[3]) / 255, sum = alpha + below;
  if (!(alpha > 0)) return;
  for (int c = 0; c < 3; ++c) {
    const auto ink = float(drawn >> (16 - 8 * c) & 255);
    codes[c] = std::uint8_t(std::min(255.0f, (ink + below * float(codes[c])) / sum + 0.5f));
  }
  codes[3] = std::uint8_t(255 * sum + 0.5f);
}

/// An RGB picture as a Cairo surface, written back when done; of one with alpha, a sheet that is laid over it.
class Canvas {
 public:
  explicit Canvas(Image8& image) : image_(image) {
    assert(image.channels == 3 || image.channels == 4);
    const cairo_format_t format = has_alpha() ? CAIRO_FORMAT_ARGB32 : CAIRO_FORMAT_RGB24;
    surface_.reset(cairo_image_surface_create(format, image.width, image.height));
    cairo_surface_flush(surface_.get());
    if (!has_alpha()) copy_picture();
    cairo_surface_mark_dirty(surface_.get());
    cairo_.reset(cairo_create(surface_.get()));
    use_font();
  }
  ~Canvas() {
    cairo_surface_flush(surface_.get());
    if (has_alpha()) {
      for_pixels([](std::uint32_t packed, std::uint8_t* codes) { blend_over(packed, codes); });
      return;
    }
    for_pixels([](std::uint32_t packed, std::uint8_t* codes) {
      codes[0] = std::uint8_t(packed >> 16), codes[1] = std::uint8_t(packed >> 8), codes[2] = std::uint8_t(packed);
    });
  }
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  cairo_t* get() const { return cairo_.get(); }

 private:
  struct Free {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
  };
  bool has_alpha() const { return image_.channels == 4; }
  void copy_picture() {
    for_pixels([](std::uint32_t& packed, const std::uint8_t* codes) {
      packed = std::uint32_t(codes[0]) << 16 | std::uint32_t(codes[1]) << 8 | codes[2];
    });
  }
  /// Grey antialiasing and no hinting: the same letters on every screen.
  void use_font() const {
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(get(), options);
    cairo_font_options_destroy(options);
    cairo_select_font_face(get(), font, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  }
  template <class Action>
  void for_pixels(const Action& action) {
    unsigned char* data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    for (int y = 0; y < image_.height; ++y) {
      auto* row = reinterpret_cast<std::uint32_t*>(data + std::size_t(y) * stride);
      for (int x = 0; x < image_.width; ++x) action(row[x], image_.pixel(x, y));
    }
  }

  Image8& image_;
  std::unique_ptr<cairo_surface_t, Free> surface_;
  std::unique_ptr<cairo_t, Free> cairo_;
};

void set_code(cairo_t* cairo, const Eigen::Matrix<std::uint8_t, 3, 1>& code) {
  cairo_set_source_rgb(cairo, code[0] / 255.0, code[1] / 255.0, code[2] / 255.0);
}

void rounded_rectangle(cairo_t* cairo, double x, double y, double width, double height, double radius) {
  constexpr double quarter = 1.5707963267948966;
  cairo_new_sub_path(cairo);
  cairo_arc(cairo, x + width - radius, y + radius, radius, -quarter, 0);
  cairo_arc(cairo, x + width - radius, y + height - radius, radius, 0, quarter);
  cairo_arc(cairo, x + radius, y + height - radius, radius, quarter, 2 * quarter);
  cairo_arc(cairo, x + radius, y + radius, radius, 2 * quarter, 3 * quarter);
  cairo_close_path(cairo);
}

double text_width(cairo_t* cairo, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(cairo, text.c_str(), &extents);
  return extents.x_advance;
}

void write_text(cairo_t* cairo, const std::string& text, double x, double baseline) {
  cairo_move_to(cairo, x, baseline);
  cairo_show_text(cairo, text.c_str());
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", std::abs(value) < 1e-12 ? 0.0 : value);
  return text;
}

void draw_plate(cairo_t* cairo, double x, double y, double width, double height, double radius) {
  rounded_rectangle(cairo, x, y, width, height, radius);
  cairo_set_source_rgba(cairo, 0.07, 0.075, 0.09, 0.62);
  cairo_fill(cairo);
}

constexpr double last_of_ramp = 0.9999;  // color_of_value() is the limit's red from 1 on

struct Bar {
  double x, y, width, height, letter;  // [px] of the ramp
};

void draw_ramp(cairo_t* cairo, const Bar& bar) {
  const int num_steps = std::max(int(bar.height), 1);
  cairo_set_antialias(cairo, CAIRO_ANTIALIAS_NONE);
  for (int i = 0; i < num_steps; ++i) {
    set_code(cairo, code_of_value((i + 0.5) / num_steps * last_of_ramp));
    cairo_rectangle(cairo, bar.x, bar.y + bar.height - i - 1, bar.width, 1);
    cairo_fill(cairo);
  }
  cairo_set_antialias(cairo, CAIRO_ANTIALIAS_DEFAULT);
}

/// The red of a reached limit, apart from the ramp.
void draw_cap(cairo_t* cairo, const Bar& bar) {
  const double height = std::round(0.55 * bar.letter), gap = std::max(1.0, std::round(0.12 * bar.letter));
  set_code(cairo, code_of_value(1));
  cairo_rectangle(cairo, bar.x, bar.y - gap - height, bar.width, height);
  cairo_fill(cairo);
}

std::vector<double> even_ticks(const Legend& legend) {
  const double span = legend.high - legend.low, step = tick_step(span);
  std::vector<double> ticks;
  for (double value = std::ceil(legend.low / step - 1e-9) * step; value <= legend.high + 1e-9 * span; value += step)
    ticks.push_back(value);
  return ticks;
}

/// Its low end, then 1, 2, 5 times powers of ten (of a long bar: powers only) as far apart as letters need.
std::vector<double> logarithmic_ticks(const Legend& legend) {
  std::vector<double> ticks{legend.low};
  for (double power = 0.01; power <= legend.high; power *= 10)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * power;
      if (value > legend.high * (1 + 1e-9) || (factor > 1 && legend.high > 1000)) break;
      if (place_on(legend, value) - place_on(legend, ticks.back()) >= 0.075) ticks.push_back(value);
    }
  return ticks;
}

std::vector<double> legend_ticks(const Legend& legend) {
  return legend.logarithmic ? logarithmic_ticks(legend) : even_ticks(legend);
}

void draw_ticks(cairo_t* cairo, const Bar& bar, const Legend& legend) {
  cairo_set_font_size(cairo, bar.letter);
  cairo_set_line_width(cairo, std::max(1.0, bar.letter / 12));
  for (const double value : legend_ticks(legend)) {
    const double y = bar.y + bar.height * (1 - place_on(legend, value));
    cairo_set_source_rgb(cairo, 0.95, 0.95, 0.95);
    cairo_move_to(cairo, bar.x + bar.width, y);
    cairo_line_to(cairo, bar.x + bar.width + 0.3 * bar.letter, y);
    cairo_stroke(cairo);
    write_text(cairo, number_text(value), bar.x + bar.width + 0.5 * bar.letter, y + 0.36 * bar.letter);
  }
}

}  // namespace

double tick_step(double span, int num_ticks) {
  const double rough = span / num_ticks, power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough * 0.8) return factor * power;
  return 10 * power;
}

double place_on(const Legend& legend, double value) {
  if (!legend.logarithmic) return (value - legend.low) / (legend.high - legend.low);
  const auto along = [&](double at) { return legend.low > 0 ? std::log(at) : std::log1p(at); };
  return (along(value) - along(legend.low)) / (along(legend.high) - along(legend.low));
}

Vector3f color_on(const Legend& legend, double value) {
  const double place = place_on(legend, value);
  if (legend.ends_at_limit) return color_of_value(place >= 1 - legend.slack ? 1 : place);
  return color_of_value(place > last_of_ramp ? last_of_ramp : place);
}

void draw_legend(Image8& image, const Legend& legend) {
  if (!(legend.high > legend.low)) return;
  const Canvas canvas(image);
  cairo_t* cairo = canvas.get();
  const double letter = std::max(9.0, 0.030 * image.height), margin = 0.9 * letter;
  cairo_set_font_size(cairo, letter);
  double label_width = 0;
  for (const double value : legend_ticks(legend))
    label_width = std::max(label_width, text_width(cairo, number_text(value)));

  Bar bar{0, 0, std::round(1.1 * letter), std::round(0.52 * image.height), letter};
  const double inner_width = std::max(text_width(cairo, legend.title), bar.width + 0.5 * letter + label_width);
  const double plate_width = inner_width + 2 * margin, plate_height = bar.height + 3.4 * letter + margin;
  const double left = std::round(image.width - plate_width - margin),
               top = std::round(0.5 * (image.height - plate_height));
  bar.x = std::round(left + margin);
  bar.y = std::round(top + 3.1 * letter);

  draw_plate(cairo, left, top, plate_width, plate_height, 0.5 * letter);
  cairo_set_source_rgb(cairo, 0.97, 0.97, 0.97);
  write_text(cairo, legend.title, left + margin, top + margin + 0.75 * letter);
  draw_ramp(cairo, bar);
  if (legend.ends_at_limit) draw_cap(cairo, bar);
  draw_ticks(cairo, bar, legend);
}

void draw_label(Image8& image, const std::string& text, float x, float y, const LabelOptions& options) {
  const Canvas canvas(image);
  cairo_t* cairo = canvas.get();
  const double letter = std::max(9.0, double(options.size) * image.height);
  cairo_set_font_size(cairo, letter);
  const double width = text_width(cairo, text) + (options.backed ? 0.9 * letter : 0);
  const double left = double(x) * image.width - (options.centred ? 0.5 * width : 0), top = double(y) * image.height,
               pad = 0.45 * letter;
  if (options.backed) draw_plate(cairo, left, top, width, 1.25 * letter + pad, 0.3 * letter);
  const Vector3f& color = options.color;
  cairo_set_source_rgb(cairo, double(color[0]), double(color[1]), double(color[2]));
  write_text(cairo, text, left + (options.backed ? pad : 0), top + 0.95 * letter + (options.backed ? 0.5 * pad : 0));
}

/// Puts a row of a picture, transparent or not, onto an opaque one.
static void lay_row(const Image8& image, int y, std::uint8_t* to) {
  if (image.channels == 3) {
    std::copy_n(image.pixel(0, y), 3 * image.width, to);
    return;
  }
  for (int x = 0; x < image.width; ++x, to += 3) {
    const std::uint8_t* from = image.pixel(x, y);
    const float alpha = float(from[3]) / 255;
    for (int c = 0; c < 3; ++c) to[c] = std::uint8_t(alpha * float(from[c]) + (1 - alpha) * float(to[c]) + 0.5f);
  }
}

Image8 contact_sheet(const std::vector<LabelledImage>& pictures, int columns, const SheetStyle& style) {
  if (pictures.empty()) return {};
  assert(columns > 0);
  const Image8& first = pictures.front().image;
  const int num_columns = std::min(columns, int(pictures.size()));
  const int num_rows = (int(pictures.size()) + num_columns - 1) / num_columns;
  const int letter = std::max(10, int(style.letter_share * float(first.height))), gap = std::max(4, first.width / 60),
            caption = 2 * letter;
  const int cell_width = first.width + gap, cell_height = first.height + caption + gap;
  Image8 sheet(num_columns * cell_width + gap, num_rows * cell_height + gap, 3);
  for (std::size_t i = 0; i < sheet.values.size(); i += 3)
    sheet.values[i] = 24, sheet.values[i + 1] = 26, sheet.values[i + 2] = 30;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Image8& image = pictures[i].image;
    assert(image.width == first.width && image.height == first.height);
    const int left = gap + int(i) % num_columns * cell_width, top = gap + int(i) / num_columns * cell_height;
    for (int y = 0; y < image.height; ++y) lay_row(image, y, sheet.pixel(left, top + y));
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const int left = gap + int(i) % num_columns * cell_width, top = gap + int(i) / num_columns * cell_height;
    const int label_top = top + first.height + letter / 3;
    draw_label(sheet, pictures[i].label, float(left) / float(sheet.width), float(label_top) / float(sheet.height),
               {.size = float(letter) / float(sheet.height), .backed = false});
  }
  return sheet;
}

Image8 present(const Image& linear, const RenderScene& scene, ToneCurve curve) {
  Image8 shown = tone_map(linear, {.curve = curve, .exposure_stops = scene.exposure_stops});
  if (scene.legend) draw_legend(shown, *scene.legend);
  for (const Caption& caption : scene.captions)
    draw_label(shown, caption.text, caption.x, caption.y, {.size = 0.045f, .centred = true});
  return shown;
}

}  // namespace umax
